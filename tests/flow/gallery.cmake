find_program(LDP_PLAIN_PYTHON NAMES python3)
if(LDP_PLAIN_PYTHON)
  add_test(NAME Gallery.HostileSlowAndManyClients COMMAND ${LDP_PLAIN_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/gallery_check.py
    $<TARGET_FILE:ldp> ${PROJECT_SOURCE_DIR}/tests/golden/gathered_jpeg.ldp)
  set_tests_properties(Gallery.HostileSlowAndManyClients PROPERTIES TIMEOUT ${LDP_TEST_SECONDS} COST 60
    ENVIRONMENT "LDP_SANITIZED=${LDP_SANITIZE}")
endif()
