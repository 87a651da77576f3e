// Opens cameras, buttons and status channels by URL, of hardware and simulated (drivers/interface/url.h).
// Which there are stands in rows by scheme: drivers/hardware.cpp, sim/devices.cpp.
#pragma once

#include <memory>
#include <string>

#include "drivers/interface/button.h"
#include "drivers/interface/camera.h"
#include "drivers/interface/status.h"

namespace ldp {

// Throw std::runtime_error, as opening would, for what is wrong with the URL's text alone.
void check_camera(const std::string& url);
void check_button(const std::string& url);
void check_status(const std::string& url);

// Open or throw std::runtime_error: what was tried, why it failed, what to do.
std::unique_ptr<CameraDevice> open_camera(const std::string& url);
std::unique_ptr<Button> open_button(const std::string& url);
std::unique_ptr<StatusChannel> open_status(const std::string& url);
std::unique_ptr<StatusListener> open_status_listener(const std::string& url);

}  // namespace ldp
