add_executable(solve_bench solve_bench.cpp solve_volumes.cpp solve_captures.cpp captures.cpp solve_reference.cpp)
target_link_libraries(solve_bench PRIVATE ldp_solve ldp_photos ldp_poses ldp_arc ldp_captures ldp_rectify ldp_sweep ldp_defaults)
target_compile_definitions(solve_bench PRIVATE LDP_SHARED_DATA="${LDP_SHARED_DATA}")
