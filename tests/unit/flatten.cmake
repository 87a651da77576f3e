ldp_test(flatten_test SOURCES flatten_test.cpp USES ldp_rectify)
