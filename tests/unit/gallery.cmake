ldp_test(gallery_test SOURCES gallery_test.cpp USES ldp_gallery ldp_panorama nlohmann_json::nlohmann_json)
