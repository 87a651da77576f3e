ldp_test(transforms_test SOURCES transforms_test.cpp colmap_test.cpp USES ldp_captures nlohmann_json::nlohmann_json)
