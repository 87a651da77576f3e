ldp_test(colour_test SOURCES colour_test.cpp photo_sampler_test.cpp USES ldp_colour)
