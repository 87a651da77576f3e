ldp_test(devices_test SOURCES devices_test.cpp USES ldp_backends ldp_hardware ldp_sim_devices ldp_photos)
ldp_test(card_test SOURCES card_test.cpp USES ldp_card ldp_service ldp_backends ldp_hardware)
ldp_test(session_state_test SOURCES session_state_test.cpp USES ldp_service ldp_backends ldp_hardware)
ldp_test(service_parts_test SOURCES service_parts_test.cpp USES ldp_service ldp_backends ldp_hardware)
# Many frames through the whole choice; the shorter sweeps run everywhere.
set(long_sweeps FrameChoice.NeighboursOverlapByTheWantedShareAtAnySpeed FrameChoice.AJumpThatNothingIsKnownOfDoesNotDecideTheDirection
                  FrameChoice.GoingBackKeepsNothingTwiceAndIsTold FrameChoice.AHandThatRestsAndJumpsLosesNoPicture)
list(JOIN long_sweeps ":" long_sweeps)
ldp_test(frame_choice_test SOURCES frame_choice_test.cpp NATIVE_ONLY ${long_sweeps}
  SLOW_EMULATED FrameChoice.NoAngleEndsASweepThatHasNotComeRound:FrameChoice.ATurnIsOverWhenTheFirstFrameComesIntoViewAgainWhateverTheAnglesSay
  USES ldp_service ldp_backends ldp_hardware ldp_photos nlohmann_json::nlohmann_json)
ldp_test(capture_store_test SOURCES capture_store_test.cpp NATIVE_ONLY CaptureStoreTest.ABuildBeyondItsMemoryFailsAlone USES ldp_service ldp_backends ldp_hardware ldp_photos nlohmann_json::nlohmann_json)
ldp_test(build_verdict_test SOURCES build_verdict_test.cpp USES ldp_service ldp_backends ldp_hardware)
ldp_test(sweep_run_test SOURCES sweep_run_test.cpp USES ldp_service ldp_backends ldp_hardware ldp_photos)
ldp_test(config_test SOURCES config_test.cpp USES ldp_service ldp_backends ldp_hardware)
if(LDP_DRIVERS)
  find_package(LCMLean REQUIRED)
  ldp_test(lcm_test SOURCES lcm_test.cpp NATIVE_ONLY Stranger.* USES ldp_backends ldp_hardware LCMLean::lcm)
  if(NOT CMAKE_CROSSCOMPILING)  # there all tests are one program, which keeps the kernel's calls
    ldp_test(v4l2_test SOURCES v4l2_test.cpp USES ldp_drivers)
  endif()
endif()
if(NOT CMAKE_CROSSCOMPILING)  # it replaces operator new of its whole program
  ldp_test(no_memory_test SOURCES no_memory_test.cpp USES ldp_service ldp_backends ldp_hardware ldp_panorama ldp_photos)
  if(LDP_SANITIZE MATCHES thread)  # whose own operator new comes second
    target_link_options(no_memory_test PRIVATE -Wl,--allow-multiple-definition)
  endif()
endif()
