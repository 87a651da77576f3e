ldp_test(layers_test SOURCES fusion_test.cpp layers_test.cpp lightness_test.cpp outlines_test.cpp simpler_maps_test.cpp view_kernels_test.cpp USES ldp_layers)
