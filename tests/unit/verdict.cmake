ldp_test(verdict_test SOURCES verdict_test.cpp USES ldp_verdict)
