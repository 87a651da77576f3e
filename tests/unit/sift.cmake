ldp_test(sift_test SOURCES sift_kernels_test.cpp sift_test.cpp USES ldp_poses)
