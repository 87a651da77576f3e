# Language, warnings, sanitizers: what every target of the project is compiled with.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3")
set(CMAKE_C_FLAGS_RELEASE "-O3")

find_program(CCACHE ccache)
if(CCACHE)
  # Relative to the project: every checkout of it finds what another one compiled.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=true ${CCACHE})
endif()

add_library(ldp_defaults INTERFACE)
# Assertions in headers tell their names: as they are on a device, the same wherever the sysroot lies. ccache makes them relative.
if(CMAKE_SYSROOT)
  file(RELATIVE_PATH relative_sysroot ${CMAKE_BINARY_DIR} ${CMAKE_SYSROOT})
  target_compile_options(ldp_defaults INTERFACE -fmacro-prefix-map=${CMAKE_SYSROOT}= -fmacro-prefix-map=${relative_sysroot}=)
endif()
# No contraction of a*b+c: poses and tables must not depend on whether the machine has a fused multiply-add.
target_compile_options(ldp_defaults INTERFACE -ffp-contract=off)
target_compile_options(ldp_defaults INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion
                                              -Wnon-virtual-dtor -Wold-style-cast -Wcast-qual)
# 32-bit systems: files and file systems beyond 2 GiB.
target_compile_definitions(ldp_defaults INTERFACE _FILE_OFFSET_BITS=64)
if(LDP_WERROR)
  target_compile_options(ldp_defaults INTERFACE -Werror)
endif()
if(LDP_SANITIZE)
  target_compile_options(ldp_defaults INTERFACE -fsanitize=${LDP_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(ldp_defaults INTERFACE -fsanitize=${LDP_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL Clang)
    # By a path that is the same in every checkout: compilers' caches know the command again.
    file(RELATIVE_PATH ignored ${CMAKE_BINARY_DIR} ${PROJECT_SOURCE_DIR}/toolchain/cmake/sanitizers.ignore)
    target_compile_options(ldp_defaults INTERFACE -fsanitize-ignorelist=${ignored})
    if(LDP_SANITIZE MATCHES fuzzer)
      target_compile_options(ldp_defaults INTERFACE -fsanitize-coverage-ignorelist=${ignored})
    endif()
  endif()
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(nlohmann_json REQUIRED)
