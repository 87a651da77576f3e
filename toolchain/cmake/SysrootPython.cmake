# The target's Python in its sysroot, under the names of FindPython3, which would take this machine's headers or names for
# the target's. The interpreter runs under the emulator.
set(Python3_Development.Module_FOUND FALSE)
file(GLOB _headers ${CMAKE_SYSROOT}/usr/include/python3.*/Python.h)
if(_headers MATCHES "/python3\\.([0-9]+)/Python\\.h$")
  set(Python3_Development.Module_FOUND TRUE)
  get_filename_component(Python3_INCLUDE_DIRS ${_headers} DIRECTORY)
  set(Python3_SOABI cpython-3${CMAKE_MATCH_1}-${CMAKE_LIBRARY_ARCHITECTURE})
  set(Python3_EXECUTABLE ${CMAKE_CROSSCOMPILING_EMULATOR} ${CMAKE_SYSROOT}/usr/bin/python3.${CMAKE_MATCH_1})
endif()
