add_executable(verdict_bench verdict/verdict_bench.cpp verdict/judged_sweep.cpp verdict/spoiled_sweeps.cpp verdict/summary.cpp)
target_link_libraries(verdict_bench PRIVATE ldp_defaults ldp_pipeline ldp_view ldp_captures ldp_sim_scene nlohmann_json::nlohmann_json)
