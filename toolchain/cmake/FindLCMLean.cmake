# LCM's library and code generator. lcm.pc requires glib-2.0.pc, which liblcm-dev does not depend on, so pkg-config fails.
find_path(LCMLean_INCLUDE_DIR lcm/lcm-cpp.hpp)
find_library(LCMLean_LIBRARY lcm)
find_program(LCM_GEN lcm-gen)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LCMLean REQUIRED_VARS LCMLean_LIBRARY LCMLean_INCLUDE_DIR LCM_GEN)
if(LCMLean_FOUND AND NOT TARGET LCMLean::lcm)
  add_library(LCMLean::lcm UNKNOWN IMPORTED)
  set_target_properties(LCMLean::lcm PROPERTIES IMPORTED_LOCATION "${LCMLean_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${LCMLean_INCLUDE_DIR}" INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${LCMLean_INCLUDE_DIR}")
endif()
mark_as_advanced(LCMLean_INCLUDE_DIR LCMLean_LIBRARY LCM_GEN)
