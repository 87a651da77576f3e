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
  void (*check)(const Url&);
  std::unique_ptr<Device> (*open)(const Url&);
};

constexpr std::array<BackEnd<CameraDevice>, 4> kCameras = {
    {{"libcamera", check_libcamera_camera, open_libcamera_camera},
     {"v4l2", check_v4l2_camera, open_v4l2_camera},
     {"folder", check_folder_camera, open_folder_camera},
     {"scene", check_scene_camera, open_scene_camera}}};
constexpr std::array<BackEnd<Button>, 3> kButtons = {{{"gpiod", check_gpiod_button, open_gpiod_button},
                                                      {"script", check_script_button, open_script_button},
                                                      {"keyboard", check_keyboard_button, open_keyboard_button}}};
constexpr std::array<BackEnd<StatusChannel>, 3> kStatuses = {{{"lcm", check_lcm, open_lcm_status},
                                                              {"led", check_gpiod_led, open_gpiod_led},
                                                              {"console", check_console_status, open_console_status}}};
constexpr std::array<BackEnd<StatusListener>, 1> kListeners = {{{"lcm", check_lcm, open_lcm_listener}}};

template <typename Device, size_t count>
const BackEnd<Device>& back_end_of(const Url& url, const char* kind,
                                   const std::array<BackEnd<Device>, count>& back_ends) {
  std::string known;
  for (const auto& back_end : back_ends) {
    if (url.scheme() == back_end.scheme) return back_end;
    known += std::string(known.empty() ? "" : ", ") + back_end.scheme + ":";
  }
  throw std::runtime_error("'" + url.text() + "': no " + kind + " of that kind; known: " + known);
}

template <typename BackEnds>
void check(const std::string& text, const char* kind, const BackEnds& back_ends) {
  const Url url(text);
  back_end_of(url, kind, back_ends).check(url);
}

template <typename BackEnds>
auto open(const std::string& text, const char* kind, const BackEnds& back_ends) {
  const Url url(text);
  return back_end_of(url, kind, back_ends).open(url);
}

}  // namespace

void check_camera(const std::string& url) { check(url, "camera", kCameras); }
void check_button(const std::string& url) { check(url, "button", kButtons); }
void check_status(const std::string& url) { check(url, "status", kStatuses); }

std::unique_ptr<CameraDevice> open_camera(const std::string& url) { return open(url, "camera", kCameras); }
std::unique_ptr<Button> open_button(const std::string& url) { return open(url, "button", kButtons); }
std::unique_ptr<StatusChannel> open_status(const std::string& url) { return open(url, "status", kStatuses); }
std::unique_ptr<StatusListener> open_status_listener(const std::string& url) {
  return open(url, "status to listen to", kListeners);
}

}  // namespace ldp
