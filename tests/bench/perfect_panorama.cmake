add_executable(perfect_panorama perfect_panorama.cpp true_views.cpp surfaces_of_photos.cpp surfaces_of_scene.cpp
               depth_truth.cpp)
target_link_libraries(perfect_panorama PRIVATE ldp_render ldp_arc ldp_images ldp_transforms ldp_types ldp_sim_scene
                      ldp_defaults)
