ldp_test(ldp_test SOURCES ldp_test.cpp USES ldp_panorama ldp_photos)
