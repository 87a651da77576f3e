ldp_test(solve_test SOURCES solve_test.cpp tiling_test.cpp USES ldp_solve)
