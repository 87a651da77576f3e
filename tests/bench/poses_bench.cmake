add_executable(poses_bench poses_bench.cpp)
target_link_libraries(poses_bench PRIVATE ldp_defaults ldp_poses ldp_arc ldp_photos ldp_sim_capture nlohmann_json::nlohmann_json)
target_compile_definitions(poses_bench PRIVATE LDP_SHARED_DATA="${LDP_SHARED_DATA}")
