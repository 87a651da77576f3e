ldp_test(export_test SOURCES export_test.cpp USES ldp_export ldp_photos ldp_captures)
