# An emulator of another word size does not begin an instruction again after SIGBUS.
ldp_test(gallery_test SOURCES gallery_test.cpp NATIVE_ONLY GalleryTest.AFileThatIsCutShortWhileItIsMappedEndsNothing
  USES ldp_gallery ldp_gallery_http ldp_panorama nlohmann_json::nlohmann_json)
