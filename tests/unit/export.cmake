ldp_test(export_test SOURCES export_test.cpp USES ldp_export ldp_images ldp_transforms)
target_include_directories(export_test PRIVATE ${PROJECT_SOURCE_DIR}/tests/golden)
target_include_directories(export_test PRIVATE ${PROJECT_SOURCE_DIR}/core/export)
