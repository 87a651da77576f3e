ldp_test(render_test SOURCES render_test.cpp USES ldp_render)
