if(LDP_DRIVERS)
  find_package(LCMLean REQUIRED)
  ldp_test(ldpd_test SOURCES ldp_capture_test.cpp ldpd_builds_test.cpp ldpd_button_test.cpp ldpd_kills_test.cpp ldpd_lcm_test.cpp
           ldpd_test.cpp service_faults_test.cpp
           USES ldp_service ldp_photos ldp_backends ldp_hardware LCMLean::lcm)
  target_compile_definitions(ldpd_test PRIVATE LDPD_PROGRAM="$<TARGET_FILE:ldpd>" LDP_DEVICE_PROGRAM="$<TARGET_FILE:ldp-device>")
  target_compile_definitions(ldpd_test PRIVATE LDP_FAULTS="$<TARGET_FILE:faults>")
  add_dependencies(ldpd_test ldpd ldp-device faults)
  find_program(LDP_PLAIN_PYTHON NAMES python3)
  if(LDP_PLAIN_PYTHON)
    add_test(NAME FaultMatrix.EveryFaultOfEveryCallOnce
      COMMAND ${LDP_PLAIN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/fault_matrix.py --short ${PROJECT_BINARY_DIR})
    add_test(NAME PowerCut.NothingThatWasReportedIsLostAtAnyStep
      COMMAND ${LDP_PLAIN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/power_cut.py ${PROJECT_BINARY_DIR})
    add_test(NAME Soak.TwoHundredCaptures
      COMMAND ${LDP_PLAIN_PYTHON} ${PROJECT_SOURCE_DIR}/toolchain/soak --captures 200 --build ${PROJECT_BINARY_DIR})
    add_test(NAME Soak.ItsVerdictOnSeriesWhoseTruthIsKnown
      COMMAND ${LDP_PLAIN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/soak_test.py ${PROJECT_SOURCE_DIR}/toolchain/soak)
    set_tests_properties(FaultMatrix.EveryFaultOfEveryCallOnce PowerCut.NothingThatWasReportedIsLostAtAnyStep
      Soak.TwoHundredCaptures PROPERTIES TIMEOUT ${LDP_LONG_TEST_SECONDS} COST 60)  # long ones first
  endif()
endif()
if(LDP_DRIVERS)
  add_test(NAME TheSampleConfigurationIsGood COMMAND ldpd --check-config --config ${PROJECT_SOURCE_DIR}/device/systemd/ldpd.toml)
  find_program(SYSTEMD_ANALYZE systemd-analyze)
  if(SYSTEMD_ANALYZE)
    # Its only complaint may be that the program is not installed here.
    add_test(NAME TheServiceUnitIsGood COMMAND sh -c
      "if ${SYSTEMD_ANALYZE} verify ${PROJECT_BINARY_DIR}/device/systemd/ldpd.service 2>&1 | grep ldpd.service | grep -v 'is not executable' | grep -v 'man '; then exit 1; fi")
    add_test(NAME TheGallerysUnitsAreGood COMMAND sh -c
      "if ${SYSTEMD_ANALYZE} verify ${PROJECT_BINARY_DIR}/device/systemd/ldp-gallery.service ${PROJECT_SOURCE_DIR}/device/systemd/ldp-gallery.socket 2>&1 | grep ldp-gallery | grep -v 'is not executable'; then exit 1; fi")
    add_test(NAME TheGalleryIsExposedByLessThan2 COMMAND
      ${SYSTEMD_ANALYZE} security --no-pager --offline=true --threshold=19 ${PROJECT_BINARY_DIR}/device/systemd/ldp-gallery.service)
    # In tenths.
    add_test(NAME TheServiceIsExposedByLessThan2 COMMAND
      ${SYSTEMD_ANALYZE} security --no-pager --offline=true --threshold=19 ${PROJECT_BINARY_DIR}/device/systemd/ldpd.service)
    if(LDP_SANITIZE)
      ldp_not_under_sanitizers("the unit's filter of system calls and its limits leave no room for them" TheServiceUnderARealSystemd)
    else()
      add_test(NAME TheServiceUnderARealSystemd COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/systemd.sh
        ${PROJECT_BINARY_DIR}/device/systemd/ldpd.service $<TARGET_FILE:ldpd>)
      set_tests_properties(TheServiceUnderARealSystemd PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300)
    endif()
  endif()
endif()

# The service as it is built without drivers.
add_executable(ldpd_without_drivers ${PROJECT_SOURCE_DIR}/device/service/ldpd.cpp)
target_link_libraries(ldpd_without_drivers PRIVATE ldp_service ldp_backends ldp_no_hardware ldp_defaults)
target_include_directories(ldpd_without_drivers SYSTEM PRIVATE ${CLI11_INCLUDE_DIR})
target_compile_definitions(ldpd_without_drivers PRIVATE LDP_VERSION="${PROJECT_VERSION}")
set_target_properties(ldpd_without_drivers PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)  # beside ldp
add_dependencies(ldpd_without_drivers ldp)
add_test(NAME WithoutDrivers.ASweepIsTakenAndOtherCamerasAreRefused
  COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/without_drivers.sh $<TARGET_FILE:ldpd_without_drivers>)
