ldp_test(estimate_test SOURCES estimate_test.cpp SLOW_EMULATED Estimate.* USES ldp_estimate ldp_sim_capture ldp_panorama)
