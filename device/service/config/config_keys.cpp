#include "device/service/config/config_keys.h"

#include <cmath>
#include <sstream>
#include <type_traits>
#include <utility>

#include "core/captures/field_of_view.h"
#include "device/backends/open.h"
#include "device/service/config/config_checks.h"
#include "drivers/interface/plain_number.h"
#include "drivers/interface/url.h"

namespace ldp {
namespace {

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

std::string quoted(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : ", ") + quoted(text);
  return "[" + list + "]";
}

void read_text(const toml::node& node, TextCheck check, const Complain& complain,
               const std::function<void(std::string)>& keep) {
  const auto value = node.value_exact<std::string>();
  if (!value) return complain(node, "expected a text in quotes");
  const std::string wrong = complaint_of(check, *value);
  if (!wrong.empty()) complain(node, wrong);
  keep(*value);
}

ConfigKey text_key(std::string name, std::string comment, std::string Config::*field, TextCheck check = nullptr) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            read_text(node, check, complain, [&](std::string text) { config.*field = std::move(text); });
          },
          [=](const Config& config) { return quoted(config.*field); }};
}

ConfigKey list_key(std::string name, std::string comment, std::vector<std::string> Config::*field,
                   TextCheck check = nullptr) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            const toml::array* const list = node.as_array();
            if (list == nullptr) return complain(node, "expected a list of texts, as in [\"...\", \"...\"]");
            (config.*field).clear();
            for (const toml::node& entry : *list)
              read_text(entry, check, complain, [&](std::string text) { (config.*field).push_back(std::move(text)); });
          },
          [=](const Config& config) { return quoted(config.*field); }};
}

template <typename Number>
ConfigKey number_key(std::string name, std::string comment, Number Config::*field, NumberRange range,
                     bool or_zero = false) {
  constexpr bool kWhole = std::is_integral_v<Number>;
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            const auto value = kWhole && !node.is_integer() ? std::nullopt : node.value<double>();
            const bool is_within = value && std::isfinite(*value) && *value >= range.low && *value <= range.high;
            if (!is_within && !(or_zero && value == 0.0)) {
              return complain(node, std::string("expected ") + (or_zero ? "0 or " : "") + "a " +
                                        (kWhole ? "whole " : "") + "number from " + plain_number(range.low) + " to " +
                                        plain_number(range.high));
            }
            config.*field = static_cast<Number>(*value);
          },
          [=](const Config& config) { return plain_number(static_cast<double>(config.*field)); }};
}

ConfigKey flag_key(std::string name, std::string comment, bool Config::*field) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            const auto value = node.value_exact<bool>();
            if (!value) return complain(node, "expected true or false");
            config.*field = *value;
          },
          [=](const Config& config) { return std::string(config.*field ? "true" : "false"); }};
}

ConfigKey mode_key() {
  return {"sweep.mode",
          "hold: the sweep lasts as long as the button is held; toggle: press to begin, press to end, 3 s cancel; "
          "left out: hold, with keyboard: toggle",
          [](const toml::node& node, Config& config, const Complain& complain) {
            const auto value = node.value_exact<std::string>();
            if (value != "toggle" && value != "hold") return complain(node, "expected \"toggle\" or \"hold\"");
            config.mode = value == "hold" ? ButtonMode::hold : ButtonMode::toggle;
          },
          [](const Config& config) {
            return quoted(std::string(mode_of(config) == ButtonMode::hold ? "hold" : "toggle"));
          }};
}

// Of the build's data, MiB, stacks of its threads included. With 2 its libraries cannot be loaded, with 8 it is
// aborted; from 12 on it tells the failure itself. With 64 it makes a panorama of five small pictures with four
// threads, not with eight.
constexpr double kLeastMemoryLimit_mib = 64;

}  // namespace

const std::vector<ConfigKey>& all_config_keys() {
  static const std::vector<ConfigKey> keys = {
      text_key("camera", "libcamera:0, v4l2:/dev/video0?width=1280&height=720&fps=30, folder:DIR, scene:NAME",
               &Config::camera, check_camera),
      text_key("button",
               "gpiod:name=LINE or gpiod:gpiochip0/17 with ?active_low=yes&bias=pull-up&debounce_ms=30, "
               "script:FILE, keyboard:",
               &Config::button, check_button),
      list_key("status", "any of lcm:udpm://239.255.76.67:7667?ttl=0, led:name=LINE, console:", &Config::status,
               check_status),
      text_key("output", "folder of the captures and panoramas", &Config::output, check_output_folder),
      text_key("device_name", "as written into captures", &Config::device_name),
      number_key("switch_off_seconds",
                 "a press that lasts so long, while the camera stands still, ends the service with exit status 10, for "
                 "the system to switch off; 0 = none does",
                 &Config::switch_off_s, {kLeastSwitchOff_s, kMostSwitchOff_s}, true),
      mode_key(),
      number_key("sweep.overlap", "of neighbouring frames", &Config::overlap, {0.3, 0.95}),
      number_key("sweep.max_frames", "the sweep ends after so many", &Config::max_frames, {3, 1000}),
      number_key("sweep.max_seconds", "the sweep ends after so long", &Config::max_seconds, {1, 3600}),
      number_key("sweep.min_frames", "a sweep with fewer is not built", &Config::min_frames, {3, 1000}),
      number_key("sweep.arm_length_m", "from the axis of the turn to the camera", &Config::arm_length_m,
                 {kLeastArm_m, kLongestArm_m}),
      number_key("sweep.fov_degrees", "horizontal field of view; 0 = unknown, it is then estimated",
                 &Config::fov_degrees, {kLeastFov_deg, kMostFov_deg}, true),
      number_key("sweep.lost_after_seconds", "without a frame the camera counts as lost", &Config::lost_after_seconds,
                 {0.2, 60}),
      number_key("sweep.reserve_mib", "of the disk that are never filled", &Config::reserve_mib, {0, 1e6}),
      flag_key("build.follow", "whether poses are found while the arm still moves", &Config::follow),
      text_key("build.program", "empty: the ldp beside ldpd", &Config::program, check_build_program),
      text_key("build.effort", "fast, standard or best: how much work a build does", &Config::effort, check_effort),
      number_key("build.threads", "0 = all cores", &Config::threads, {0, 256}),
      number_key("build.memory_limit_mib", "of the build's process, at least 64; 0 = none", &Config::memory_limit_mib,
                 {kLeastMemoryLimit_mib, 1e6}, true),
      number_key("build.niceness", "0 = as important as everything else, 19 = least", &Config::niceness, {0, 19}),
      list_key("build.options", "further options of ldp build", &Config::options),
  };
  return keys;
}

}  // namespace ldp
