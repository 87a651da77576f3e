ldp_test(images_test SOURCES images_test.cpp USES ldp_photos)
