#include "device/backends/open.h"

#include <span>
#include <stdexcept>
#include <string>

#include "drivers/hardware.h"
#include "sim/devices.h"

namespace ldp {
namespace {

template <typename Device>
const BackEnd<Device>& back_end_of(const Url& url, const char* kind, std::span<const BackEnd<Device>> hardware,
                                   std::span<const BackEnd<Device>> simulated = {}) {
  std::string known;
  for (const auto back_ends : {hardware, simulated}) {
    for (const BackEnd<Device>& back_end : back_ends) {
      if (url.scheme() == back_end.scheme) return back_end;
      known += std::string(known.empty() ? "" : ", ") + back_end.scheme + ":";
    }
  }
  throw std::runtime_error("'" + url.text() + "': no " + kind + " of that kind; known: " +
                           (known.empty() ? "none, this program was built without drivers" : known));
}

const BackEnd<CameraDevice>& camera_of(const Url& url) {
  return back_end_of(url, "camera", hardware_cameras(), simulated_cameras());
}
const BackEnd<Button>& button_of(const Url& url) {
  return back_end_of(url, "button", hardware_buttons(), simulated_buttons());
}
const BackEnd<StatusChannel>& status_of(const Url& url) { return back_end_of(url, "status", hardware_statuses()); }
const BackEnd<StatusListener>& listener_of(const Url& url) {
  return back_end_of(url, "status to listen to", hardware_listeners());
}

}  // namespace

void check_camera(const std::string& url) { camera_of(Url(url)).check(Url(url)); }
void check_button(const std::string& url) { button_of(Url(url)).check(Url(url)); }
void check_status(const std::string& url) { status_of(Url(url)).check(Url(url)); }

std::unique_ptr<CameraDevice> open_camera(const std::string& url) { return camera_of(Url(url)).open(Url(url)); }
std::unique_ptr<Button> open_button(const std::string& url) { return button_of(Url(url)).open(Url(url)); }
std::unique_ptr<StatusChannel> open_status(const std::string& url) { return status_of(Url(url)).open(Url(url)); }
std::unique_ptr<StatusListener> open_status_listener(const std::string& url) {
  return listener_of(Url(url)).open(Url(url));
}

}  // namespace ldp
