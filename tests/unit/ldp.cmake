ldp_test(ldp_test SOURCES ldp_test.cpp USES ldp_ldp ldp_images)
target_include_directories(ldp_test PRIVATE ${PROJECT_SOURCE_DIR}/tests/golden)
target_include_directories(ldp_test PRIVATE ${PROJECT_SOURCE_DIR}/core/ldp)
