find_package(nlohmann_json REQUIRED)
ldp_test(flow_test SOURCES cameras_test.cpp flow_test.cpp outputs_test.cpp scripts_test.cpp USES ldp_images ldp_transforms ldp_types nlohmann_json::nlohmann_json)
target_compile_definitions(flow_test PRIVATE LDP_PROGRAM="$<TARGET_FILE:ldp>" LDP_SOURCE="${PROJECT_SOURCE_DIR}" LDP_BUILD="${PROJECT_BINARY_DIR}")
add_dependencies(flow_test ldp)
