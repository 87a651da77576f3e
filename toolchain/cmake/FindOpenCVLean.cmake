# OpenCV's modules one by one. Debian's OpenCVConfig.cmake is in libopencv-dev only and demands every module, contrib and
# imgcodecs (137 libraries) included. Gives targets OpenCVLean::core, imgproc, features2d, calib3d, flann.
find_path(OpenCVLean_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(_opencv_libraries)
foreach(module core imgproc flann features2d calib3d)
  find_library(OpenCVLean_${module}_LIBRARY opencv_${module})
  list(APPEND _opencv_libraries OpenCVLean_${module}_LIBRARY)
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVLean REQUIRED_VARS OpenCVLean_INCLUDE_DIR ${_opencv_libraries})
if(OpenCVLean_FOUND)
  foreach(module core imgproc flann features2d calib3d)
    if(NOT TARGET OpenCVLean::${module})
      add_library(OpenCVLean::${module} UNKNOWN IMPORTED)
      set_target_properties(OpenCVLean::${module} PROPERTIES
        IMPORTED_LOCATION "${OpenCVLean_${module}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenCVLean_INCLUDE_DIR}"
        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${OpenCVLean_INCLUDE_DIR}")
    endif()
  endforeach()
endif()
mark_as_advanced(OpenCVLean_INCLUDE_DIR ${_opencv_libraries})
