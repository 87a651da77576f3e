ldp_test(layers_test SOURCES layers_test.cpp view_kernels_test.cpp USES ldp_layers)
