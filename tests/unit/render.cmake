ldp_test(render_test SOURCES render_test.cpp USES ldp_render)
ldp_test(render_kernels_test SOURCES render_kernels_test.cpp USES ldp_render)
