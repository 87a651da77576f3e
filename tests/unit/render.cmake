ldp_test(render_test SOURCES frame_extension_test.cpp render_test.cpp USES ldp_view)
ldp_test(render_kernels_test SOURCES render_kernels_test.cpp USES ldp_view)
ldp_test(view_parts_test SOURCES view_parts_test.cpp USES ldp_view)
