find_package(Ceres REQUIRED)
ldp_test(poses_test
  SOURCES poses/bundle_adjustment_test.cpp poses/estimate_poses_test.cpp poses/matching_test.cpp poses/motion_start_test.cpp
          poses/refinement_test.cpp poses/triangulation_test.cpp poses/unfit_frames_test.cpp
          poses/verification_test.cpp
  NATIVE_ONLY EstimatePoses.*:PoseEstimator.*:Triangulate.*
  USES ldp_poses ldp_sim_capture)
ldp_test(klt_tracking_test SOURCES klt_tracking_test.cpp USES ldp_poses)
ldp_test(corner_tracks_test SOURCES corner_tracks_test.cpp NATIVE_ONLY AddCornerTracks.* USES ldp_poses ldp_sim_scene)
ldp_test(reprojection_test SOURCES reprojection_test.cpp USES ldp_poses Ceres::ceres)
