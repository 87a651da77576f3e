ldp_test(poses_test SOURCES poses_test.cpp USES ldp_poses ldp_sim_scene)
