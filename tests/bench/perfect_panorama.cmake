add_executable(perfect_panorama perfect_panorama.cpp true_views.cpp surfaces_of_photos.cpp surfaces_of_scene.cpp
               depth_truth.cpp)
target_link_libraries(perfect_panorama PRIVATE ldp_view ldp_arc ldp_photos ldp_captures ldp_geometry ldp_sim_scene
                      ldp_defaults)
