if(LDP_DRIVERS)
  ldp_test(ldpd_test SOURCES ldpd_test.cpp USES ldp_images ldp_drivers)
  target_compile_definitions(ldpd_test PRIVATE LDPD_PROGRAM="$<TARGET_FILE:ldpd>" LDP_DEVICE_PROGRAM="$<TARGET_FILE:ldp-device>")
  add_dependencies(ldpd_test ldpd ldp-device)
endif()
if(LDP_DRIVERS)
  add_test(NAME TheSampleConfigurationIsGood COMMAND ldpd --check-config --config ${PROJECT_SOURCE_DIR}/device/systemd/ldpd.toml)
  find_program(SYSTEMD_ANALYZE systemd-analyze)
  if(SYSTEMD_ANALYZE)
    # Its only complaint may be that the program is not installed here.
    add_test(NAME TheServiceUnitIsGood COMMAND sh -c
      "if ${SYSTEMD_ANALYZE} verify ${PROJECT_BINARY_DIR}/device/systemd/ldpd.service 2>&1 | grep ldpd.service | grep -v 'is not executable' | grep -v 'man '; then exit 1; fi")
  endif()
endif()
