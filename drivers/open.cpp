// The one place where URLs meet back-ends.
#include <array>
#include <stdexcept>
#include <string>

#include "backends.h"
#include "devices.h"

namespace ldp {
namespace {

template <typename Device>
struct BackEnd {
  const char* scheme;
  std::unique_ptr<Device> (*open)(const Url&);
};

template <typename Device, size_t count>
std::unique_ptr<Device> open_by_scheme(const char* kind, const std::string& text,
                                       const std::array<BackEnd<Device>, count>& back_ends) {
  const Url url(text);
  std::string known;
  for (const auto& back_end : back_ends) {
    if (url.scheme() == back_end.scheme) return back_end.open(url);
    known += std::string(known.empty() ? "" : ", ") + back_end.scheme + ":";
  }
  throw std::runtime_error("'" + text + "': no " + kind + " of that kind; known: " + known);
}

}  // namespace

std::unique_ptr<CameraDevice> open_camera(const std::string& url) {
  return open_by_scheme("camera", url,
                        std::array<BackEnd<CameraDevice>, 4>{{{"libcamera", open_libcamera_camera},
                                                              {"v4l2", open_v4l2_camera},
                                                              {"folder", open_folder_camera},
                                                              {"scene", open_scene_camera}}});
}

std::unique_ptr<Button> open_button(const std::string& url) {
  return open_by_scheme(
      "button", url,
      std::array<BackEnd<Button>, 3>{
          {{"gpiod", open_gpiod_button}, {"script", open_script_button}, {"keyboard", open_keyboard_button}}});
}

std::unique_ptr<StatusChannel> open_status(const std::string& url) {
  return open_by_scheme("status", url,
                        std::array<BackEnd<StatusChannel>, 3>{
                            {{"lcm", open_lcm_status}, {"led", open_gpiod_led}, {"console", open_console_status}}});
}

std::unique_ptr<StatusListener> open_status_listener(const std::string& url) {
  return open_by_scheme("status to listen to", url,
                        std::array<BackEnd<StatusListener>, 1>{{{"lcm", open_lcm_listener}}});
}

}  // namespace ldp
