find_program(LDP_PYTHON NAMES /usr/bin/python3 python3)
if(LDP_PYTHON)
  add_test(NAME Exr.HoldsWhatThePngAndThePfmHold
    COMMAND ${LDP_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/exr_check.py $<TARGET_FILE:ldp> ${PROJECT_SOURCE_DIR}/tests/golden)
  set_tests_properties(Exr.HoldsWhatThePngAndThePfmHold PROPERTIES TIMEOUT ${LDP_TEST_SECONDS} SKIP_RETURN_CODE 77)
endif()
