find_program(LDP_PYTHON NAMES /usr/bin/python3 python3)
find_program(LDP_EXIFTOOL exiftool)
if(LDP_PYTHON AND LDP_EXIFTOOL)
  add_test(NAME Around.StereoAndDepthAgreeWithTheSceneItself
    COMMAND ${LDP_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/around_check.py $<TARGET_FILE:ldp>)
  set_tests_properties(Around.StereoAndDepthAgreeWithTheSceneItself PROPERTIES TIMEOUT ${LDP_TEST_SECONDS})
endif()
