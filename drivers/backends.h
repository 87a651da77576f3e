// The functions behind the rows of hardware.h; one vendor library per source file.
#pragma once

#include <memory>

#include "drivers/interface/button.h"
#include "drivers/interface/camera.h"
#include "drivers/interface/status.h"
#include "drivers/interface/url.h"

namespace ldp {

void check_v4l2_camera(const Url& url);
void check_libcamera_camera(const Url& url);
void check_gpiod_button(const Url& url);
void check_gpiod_led(const Url& url);
void check_lcm(const Url& url);
void check_console_status(const Url& url);

std::unique_ptr<CameraDevice> open_v4l2_camera(const Url& url);
std::unique_ptr<CameraDevice> open_libcamera_camera(const Url& url);
std::unique_ptr<Button> open_gpiod_button(const Url& url);
std::unique_ptr<StatusChannel> open_gpiod_led(const Url& url);
std::unique_ptr<StatusChannel> open_lcm_status(const Url& url);
std::unique_ptr<StatusListener> open_lcm_listener(const Url& url);
std::unique_ptr<StatusChannel> open_console_status(const Url& url);

}  // namespace ldp
