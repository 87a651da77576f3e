add_test(NAME Skips.AreToldWithTheirReasons
  COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/skips_check.sh ${CMAKE_CTEST_COMMAND} ${PROJECT_SOURCE_DIR}/tests/tell_skips.sh)
