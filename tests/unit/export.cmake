ldp_test(export_test SOURCES export_test.cpp rags_test.cpp USES ldp_export ldp_photos ldp_captures meshoptimizer::meshoptimizer nlohmann_json::nlohmann_json)
