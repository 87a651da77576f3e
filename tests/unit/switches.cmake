ldp_test(switches_test SOURCES switches_test.cpp ${PROJECT_SOURCE_DIR}/device/tool/switches.cpp USES ldp_base)
