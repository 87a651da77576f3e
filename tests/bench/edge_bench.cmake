add_executable(edge_bench edges/edge_bench.cpp edges/slender_things.cpp true_views.cpp depth_truth.cpp)
target_link_libraries(edge_bench PRIVATE ldp_view ldp_panorama ldp_photos ldp_captures ldp_sim_scene ldp_defaults
                      nlohmann_json::nlohmann_json)
