ldp_test(arc_test SOURCES arc_test.cpp USES ldp_arc)
