ldp_test(quality_test SOURCES quality_test.cpp USES ldp_view)
