set(tool ${PROJECT_SOURCE_DIR}/device/tool)
ldp_test(tool_parts_test
  SOURCES tool_parts_test.cpp ${tool}/memory_size.cpp ${tool}/output.cpp ${tool}/own_output.cpp
          ${tool}/session.cpp ${tool}/process/interrupt.cpp ${tool}/process/progress_bar.cpp
  USES ldp_base nlohmann_json::nlohmann_json)
target_include_directories(tool_parts_test SYSTEM PRIVATE ${CLI11_INCLUDE_DIR})
