ldp_test(types_test SOURCES types_test.cpp USES ldp_types)
