ldp_test(gallery_test SOURCES gallery_test.cpp USES ldp_gallery ldp_gallery_http ldp_panorama nlohmann_json::nlohmann_json)
