ldp_test(scene_test SOURCES scene_test.cpp shapes_test.cpp USES ldp_sim_capture ldp_sim_scene)
