# The Debian packages: the programs with service files, message types and man pages; libldp0, libldp-dev, python3-ldp and,
# where there is doxygen, libldp-doc. Made by toolchain/package, which also works out the dependencies from what each really needs on its own architecture.
include(GNUInstallDirs)
set(LDP_DEB_ARCH "amd64" CACHE STRING "Debian's name of the target architecture")

find_program(GZIP gzip REQUIRED)
function(install_compressed source destination)
  get_filename_component(name ${source} NAME)
  add_custom_command(OUTPUT ${name}.gz COMMAND ${GZIP} -9nc ${source} > ${name}.gz DEPENDS ${source} VERBATIM)
  string(MAKE_C_IDENTIFIER "compressed_${name}" target)
  add_custom_target(${target} ALL DEPENDS ${name}.gz)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.gz DESTINATION ${destination})
endfunction()

set(deb ${PROJECT_SOURCE_DIR}/toolchain/deb)
install(FILES ${PROJECT_SOURCE_DIR}/device/systemd/ldpd.toml DESTINATION /etc)
install(FILES ${PROJECT_SOURCE_DIR}/device/systemd/ldp-gallery.avahi DESTINATION /etc/avahi/services RENAME ldp-gallery.service)
install(FILES ${PROJECT_SOURCE_DIR}/drivers/messages.lcm DESTINATION ${CMAKE_INSTALL_DATADIR}/layered-depth-panorama)
install_compressed(${deb}/changelog ${CMAKE_INSTALL_DOCDIR})
install(FILES ${deb}/copyright ${PROJECT_SOURCE_DIR}/core/panorama/file/FORMAT.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${PROJECT_SOURCE_DIR}/core/panorama/file/FORMAT.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libldp-dev
        COMPONENT libldp-dev)
set(libraries libldp0 libldp-dev)
if(TARGET ldp_python)
  list(APPEND libraries python3-ldp)
endif()
find_program(DOXYGEN doxygen)
if(DOXYGEN)
  list(APPEND libraries libldp-doc)
  set(reference ${CMAKE_CURRENT_BINARY_DIR}/reference)
  add_custom_target(reference ALL COMMAND ${PROJECT_SOURCE_DIR}/toolchain/reference ${reference} VERBATIM)
  install(DIRECTORY ${reference}/html DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libldp-doc COMPONENT libldp-doc)
  install(FILES ${PROJECT_SOURCE_DIR}/core/panorama/file/FORMAT.md ${PROJECT_SOURCE_DIR}/device/examples/RECIPES.md
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libldp-doc COMPONENT libldp-doc)
else()
  message(STATUS "libldp-doc is not made: doxygen is absent (toolchain/setup doc)")
endif()
foreach(package ${libraries})
  install(FILES ${deb}/copyright ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${package})
endforeach()
install_compressed(${deb}/ldp.1 ${CMAKE_INSTALL_MANDIR}/man1)
install_compressed(${deb}/ldpd.8 ${CMAKE_INSTALL_MANDIR}/man8)
install_compressed(${deb}/ldp-card.8 ${CMAKE_INSTALL_MANDIR}/man8)
install_compressed(${deb}/ldp-device.1 ${CMAKE_INSTALL_MANDIR}/man1)

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL programs ${libraries})
set(CPACK_PACKAGE_NAME layered-depth-panorama)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "layered depth panoramas from one arm's-length sweep")
set(CPACK_PACKAGE_CONTACT "The layered depth panorama authors <authors@ldp.invalid>")
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${LDP_DEB_ARCH})
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME layered-depth-panorama)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAMS_DESCRIPTION "A camera service and command line that turn about 20 hand-held frames into a
layered depth panorama: a small file that shows true motion parallax. Frames
come through libcamera or V4L2, a GPIO button marks the sweep, status goes out
over LCM, and everything is computed on the device.")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS libcamera-ipa)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SUGGESTS "ffmpeg, libheif-examples, libraw-bin")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA "${deb}/postinst;${deb}/prerm;${deb}/postrm;${deb}/conffiles")

set(CPACK_DEBIAN_LIBLDP0_PACKAGE_NAME libldp0)
set(CPACK_DEBIAN_LIBLDP0_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBLDP0_DESCRIPTION "The shared library: opens, describes, renders and writes .ldp files: panoramas of a few layers with
depth, from which views with motion parallax are drawn.")
configure_file(${PROJECT_SOURCE_DIR}/device/library/libldp0.symbols deb/symbols COPYONLY)
set(CPACK_DEBIAN_LIBLDP0_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_BINARY_DIR}/deb/symbols;${deb}/triggers")

set(CPACK_DEBIAN_LIBLDP-DEV_PACKAGE_NAME libldp-dev)
set(CPACK_DEBIAN_LIBLDP-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBLDP-DEV_PACKAGE_DEPENDS "libldp0 (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBLDP-DEV_PACKAGE_SUGGESTS libldp-doc)
set(CPACK_DEBIAN_LIBLDP-DEV_DESCRIPTION "What programs in C, or that call C, need to be built with libldp0: ldp.h, files
for CMake and pkg-config, and the description of the file format.")

set(CPACK_DEBIAN_PYTHON3-LDP_PACKAGE_NAME python3-ldp)
set(CPACK_DEBIAN_PYTHON3-LDP_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON3-LDP_PACKAGE_RECOMMENDS layered-depth-panorama)
set(CPACK_DEBIAN_PYTHON3-LDP_PACKAGE_SUGGESTS libldp-doc)
set(CPACK_DEBIAN_PYTHON3-LDP_DESCRIPTION "For Python: planes of layers and rendered views as numpy arrays; building panoramas from
photographs takes the programs of layered-depth-panorama.")
set(CPACK_DEBIAN_PYTHON3-LDP_PACKAGE_CONTROL_EXTRA "${deb}/python3-ldp/prerm")

set(CPACK_DEBIAN_LIBLDP-DOC_PACKAGE_NAME libldp-doc)
set(CPACK_DEBIAN_LIBLDP-DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_LIBLDP-DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_LIBLDP-DOC_DESCRIPTION "The reference of the C, C++ and Python interfaces as pages, the description of the file
format, and recipes of commands.")

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES OFF)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
include(CPack)
