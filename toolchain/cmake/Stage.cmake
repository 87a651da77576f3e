# ldp_library(NAME SOURCES ... [USES ...] [PRIVATE_USES ...])
#
# One library per folder, named ldp_NAME. Includes name their folder from the project's root; which folder may include
# which stands in toolchain/floors.
function(ldp_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES;PRIVATE_USES" ${ARGN})
  add_library(ldp_${name} STATIC ${ARG_SOURCES})
  target_include_directories(ldp_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(ldp_${name} PUBLIC ${ARG_USES} PRIVATE ldp_defaults ${ARG_PRIVATE_USES})
endfunction()

# Kernels are compiled once more with AVX2 where there is one; the same bytes either way.
function(ldp_avx2_sources)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -mavx2)
  endif()
endfunction()
