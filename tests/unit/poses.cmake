find_package(Ceres REQUIRED)
ldp_test(poses_test SOURCES poses_test.cpp NATIVE_ONLY EstimatePoses.*:PoseEstimator.*:Triangulate.* USES ldp_poses ldp_sim_scene)
ldp_test(follow_test SOURCES follow_test.cpp USES ldp_poses)
ldp_test(reprojection_test SOURCES reprojection_test.cpp USES ldp_poses Ceres::ceres)
