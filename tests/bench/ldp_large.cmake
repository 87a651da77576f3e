add_executable(ldp_large ldp_large.cpp)
target_link_libraries(ldp_large PRIVATE ldp_panorama ldp_photos ldp_defaults)
