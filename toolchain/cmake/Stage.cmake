# ldp_library(NAME SOURCES ... [USES ...] [PRIVATE_USES ...])
#
# One library per folder, named ldp_NAME. Its public header is found by its bare name, because only the folders of the
# libraries listed in USES are on its include path: a stage that is not linked to another cannot include it.
function(ldp_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES;PRIVATE_USES" ${ARGN})
  add_library(ldp_${name} STATIC ${ARG_SOURCES})
  target_include_directories(ldp_${name} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(ldp_${name} PUBLIC ${ARG_USES} PRIVATE ldp_defaults ${ARG_PRIVATE_USES})
endfunction()
