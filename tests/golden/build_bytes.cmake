# Whole builds: the same bytes, and poses that agree, on every processor (through its emulator when cross-compiling).
find_program(LDP_PLAIN_PYTHON NAMES python3)
if(LDP_PLAIN_PYTHON)
  set(program ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:ldp>)
  set(compare ${LDP_PLAIN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/scripts/build_bytes.py)
  add_test(NAME Golden.KnownCamerasGiveTheSameBytesOnEveryMachine COMMAND ${compare}
    ${CMAKE_CURRENT_SOURCE_DIR}/build_bytes.json ${CMAKE_CURRENT_SOURCE_DIR}/captures -- ${program})
  add_test(NAME Golden.PosesAgreeOnEveryMachine COMMAND ${compare} --poses
    ${CMAKE_CURRENT_SOURCE_DIR}/poses.json ${CMAKE_CURRENT_SOURCE_DIR}/sweeps -- ${program})
  set_tests_properties(Golden.KnownCamerasGiveTheSameBytesOnEveryMachine Golden.PosesAgreeOnEveryMachine PROPERTIES TIMEOUT ${LDP_TEST_SECONDS})
endif()
