ldp_test(pipeline_test SOURCES pipeline_test.cpp USES ldp_pipeline)
