ldp_test(flow_test SOURCES cameras_test.cpp flow_test.cpp intake_test.cpp machine_faults_test.cpp outputs_test.cpp refusals_test.cpp
         scripts_test.cpp verdict_flow_test.cpp
         USES ldp_panorama ldp_photos ldp_captures ldp_geometry ldp_sim_scene nlohmann_json::nlohmann_json)
target_compile_definitions(flow_test PRIVATE LDP_PROGRAM="$<TARGET_FILE:ldp>" LDP_SOURCE="${PROJECT_SOURCE_DIR}" LDP_BUILD="${PROJECT_BINARY_DIR}")
add_library(thread_throws MODULE thread_throws.cpp)
add_library(faults MODULE faults.c)
if(LDP_SANITIZE)
  target_compile_definitions(faults PRIVATE LDP_SANITIZED)
endif()
target_compile_definitions(flow_test PRIVATE LDP_THREAD_THROWS="$<TARGET_FILE:thread_throws>" LDP_FAULTS="$<TARGET_FILE:faults>")
add_dependencies(flow_test ldp thread_throws faults)
