ldp_test(frames_test SOURCES frames_test.cpp USES ldp_captures ldp_photos)
