ldp_test(images_test SOURCES exposure_test.cpp images_test.cpp USES ldp_photos)
