ldp_test(ldp_test SOURCES ldp_test.cpp pull_push_test.cpp USES ldp_panorama ldp_photos)
ldp_test(coders_test SOURCES coders_test.cpp USES ldp_panorama ldp_photos)
