ldp_test(pipeline_test SOURCES pipeline_test.cpp USES ldp_pipeline)
ldp_test(debug_pictures_test SOURCES debug_pictures_test.cpp USES ldp_pipeline)
