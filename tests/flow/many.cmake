find_program(LDP_PLAIN_PYTHON NAMES python3)
if(LDP_PLAIN_PYTHON)
  add_test(NAME Many.EstimatesRepeatedBuildsStatusesAndSummaries
    COMMAND ${LDP_PLAIN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/many_check.py $<TARGET_FILE:ldp>)
  set_tests_properties(Many.EstimatesRepeatedBuildsStatusesAndSummaries PROPERTIES TIMEOUT ${LDP_TEST_SECONDS} COST 60
    ENVIRONMENT "LDP_SANITIZED=${LDP_SANITIZE}")
endif()
