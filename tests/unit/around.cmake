ldp_test(around_test SOURCES around_test.cpp USES ldp_export ldp_view ldp_photos ${MD_LIBRARY})
