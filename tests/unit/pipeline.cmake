ldp_test(pipeline_test SOURCES grid_layout_test.cpp pipeline_test.cpp seen_part_test.cpp USES ldp_pipeline)
ldp_test(debug_pictures_test SOURCES debug_pictures_test.cpp USES ldp_pipeline)
