ldp_test(verdict_test SOURCES measured_frames_test.cpp verdict_test.cpp USES ldp_verdict)
