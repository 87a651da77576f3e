ldp_test(sift_test SOURCES sift_test.cpp USES ldp_poses)
