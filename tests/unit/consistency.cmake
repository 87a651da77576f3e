ldp_test(consistency_test SOURCES consistency_test.cpp USES ldp_consistency)
