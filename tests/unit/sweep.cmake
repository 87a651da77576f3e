ldp_test(sweep_test SOURCES sweep_test.cpp sweep_kernels_test.cpp points_prior_test.cpp USES ldp_sweep)
