// The back-ends behind open_camera, open_button, open_status and their checks; one vendor library per source file.
#pragma once

#include <memory>

#include "button.h"
#include "camera.h"
#include "status.h"
#include "url.h"

namespace ldp {

// Each opens what a URL names; its check refuses, in the same words, what opening would refuse for the URL's text
// alone, and needs no device, network or file.
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
