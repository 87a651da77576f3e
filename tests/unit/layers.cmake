ldp_test(layers_test SOURCES layers_test.cpp USES ldp_layers)
