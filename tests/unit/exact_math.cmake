ldp_test(exact_math_test SOURCES exact_math_test.cpp USES ldp_geometry)
