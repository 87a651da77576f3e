ldp_test(rectify_test SOURCES rectify_test.cpp USES ldp_rectify)
