# The Debian package: programs, service files, message types, man pages. Made by toolchain/package, which also works out
# the dependencies (LDP_DEPENDS) from what the programs really need on their own architecture.
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
install(FILES ${PROJECT_SOURCE_DIR}/core/panorama/file/FORMAT.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${deb}/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install_compressed(${deb}/changelog ${CMAKE_INSTALL_DOCDIR})
install_compressed(${deb}/ldp.1 ${CMAKE_INSTALL_MANDIR}/man1)
install_compressed(${deb}/ldpd.8 ${CMAKE_INSTALL_MANDIR}/man8)
install_compressed(${deb}/ldp-device.1 ${CMAKE_INSTALL_MANDIR}/man1)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME layered-depth-panorama)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The layered depth panorama authors <authors@ldp.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "panoramas with depth from one arm's-length sweep")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"A camera service and command line that turn about 20 hand-held frames into a
layered depth panorama: a small file that shows true motion parallax. Frames
come through libcamera or V4L2, a GPIO button marks the sweep, status goes out
over LCM, and everything is computed on the device.")
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${LDP_DEB_ARCH})
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS libcamera-ipa)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS ffmpeg)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA "${deb}/postinst;${deb}/prerm;${deb}/postrm;${deb}/conffiles")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES OFF)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
include(CPack)
