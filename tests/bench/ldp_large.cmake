add_executable(ldp_large ldp_large.cpp)
target_link_libraries(ldp_large PRIVATE ldp_ldp ldp_images ldp_defaults)
target_include_directories(ldp_large PRIVATE ${PROJECT_SOURCE_DIR}/tests/golden)
