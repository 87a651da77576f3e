#include "sim/devices.h"

namespace ldp {
namespace {

constexpr BackEnd<CameraDevice> kCameras[] = {{"folder", check_folder_camera, open_folder_camera},
                                              {"scene", check_scene_camera, open_scene_camera}};
constexpr BackEnd<Button> kButtons[] = {{"script", check_script_button, open_script_button},
                                        {"keyboard", check_keyboard_button, open_keyboard_button}};

}  // namespace

std::span<const BackEnd<CameraDevice>> simulated_cameras() { return kCameras; }
std::span<const BackEnd<Button>> simulated_buttons() { return kButtons; }

}  // namespace ldp
