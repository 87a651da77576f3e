#include "drivers/hardware.h"

#include "drivers/backends.h"

namespace ldp {
namespace {

constexpr BackEnd<CameraDevice> kCameras[] = {{"libcamera", check_libcamera_camera, open_libcamera_camera},
                                              {"v4l2", check_v4l2_camera, open_v4l2_camera}};
constexpr BackEnd<Button> kButtons[] = {{"gpiod", check_gpiod_button, open_gpiod_button}};
constexpr BackEnd<StatusChannel> kStatuses[] = {{"lcm", check_lcm, open_lcm_status},
                                                {"led", check_gpiod_led, open_gpiod_led},
                                                {"console", check_console_status, open_console_status}};
constexpr BackEnd<StatusListener> kListeners[] = {{"lcm", check_lcm, open_lcm_listener}};

}  // namespace

std::span<const BackEnd<CameraDevice>> hardware_cameras() { return kCameras; }
std::span<const BackEnd<Button>> hardware_buttons() { return kButtons; }
std::span<const BackEnd<StatusChannel>> hardware_statuses() { return kStatuses; }
std::span<const BackEnd<StatusListener>> hardware_listeners() { return kListeners; }

}  // namespace ldp
