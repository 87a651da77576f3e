#include "device/service/config.h"

#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "device/backends/open.h"
#include "drivers/interface/button.h"
#include "drivers/interface/camera.h"
#include "drivers/interface/status.h"
#include "drivers/interface/url.h"

namespace ldp {
namespace {

// Throws what is wrong with the text of a value.
using Check = void (*)(const std::string& text);
using Complain = std::function<void(const toml::node& where, const std::string& what)>;

bool can_be_held(const std::string& button) { return !button.starts_with("keyboard:"); }

// Empty = good. Only a mode that was given can be wrong.
std::string wrong_mode(const Config& config) {
  if (config.mode != ButtonMode::hold || can_be_held(config.button)) return {};
  return "a terminal does not tell when a key is let go: keyboard: needs the mode toggle";
}

struct Key {
  std::string name;  // "sweep.overlap"
  std::string comment;
  std::function<void(const toml::node&, Config&, const Complain&)> read;
  std::function<std::string(const Config&)> write;
};

std::string plain(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

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

bool is_directory_at(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

void check_output(const std::string& folder) {
  std::error_code error;
  if (folder.empty()) throw std::runtime_error("is empty: give the folder of the captures and panoramas");
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw std::runtime_error("'" + folder + "' is no folder: give one, or remove that");
}

void check_camera_is_there(const std::string& camera) {
  check_camera(camera);
  const Url url(camera);
  if (url.scheme() == "folder" && !is_directory_at(url.path()))
    throw std::runtime_error("'" + url.text() + "': there is no folder '" + url.path() + "'");
}

void check_button_is_there(const std::string& button) {
  check_button(button);
  const Url url(button);
  std::error_code error;
  if (url.scheme() == "script" && (is_directory_at(url.path()) || !std::filesystem::exists(url.path(), error)))
    throw std::runtime_error("'" + url.text() + "': there is no file '" + url.path() + "'");
}

void check_program(const std::string& program) {
  std::error_code error;
  if (program.empty()) return;
  if (!std::filesystem::exists(program, error))
    throw std::runtime_error("there is no '" + program +
                             "': give the whole path of ldp, or nothing for the one beside ldpd");
  if (std::filesystem::is_directory(program, error) || ::access(program.c_str(), X_OK) != 0)
    throw std::runtime_error("'" + program + "' cannot be run: give the whole path of ldp, or make it executable");
}

// Empty = good.
std::string complaint_of(Check check, const std::string& text) {
  try {
    if (check != nullptr) check(text);
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

void read_text(const toml::node& node, Check check, const Complain& complain,
               const std::function<void(std::string)>& keep) {
  const auto value = node.value_exact<std::string>();
  if (!value) return complain(node, "expected a text in quotes");
  const std::string wrong = complaint_of(check, *value);
  if (!wrong.empty()) complain(node, wrong);
  keep(*value);
}

Key text_key(std::string name, std::string comment, std::string Config::*field, Check check = nullptr) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            read_text(node, check, complain, [&](std::string text) { config.*field = std::move(text); });
          },
          [=](const Config& config) { return quoted(config.*field); }};
}

Key list_key(std::string name, std::string comment, std::vector<std::string> Config::*field, Check check = nullptr) {
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
Key number_key(std::string name, std::string comment, Number Config::*field, NumberRange range, bool or_zero = false) {
  constexpr bool kWhole = std::is_integral_v<Number>;
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            const auto value = kWhole && !node.is_integer() ? std::nullopt : node.value<double>();
            const bool is_within = value && std::isfinite(*value) && *value >= range.low && *value <= range.high;
            if (!is_within && !(or_zero && value == 0.0)) {
              return complain(node, std::string("expected ") + (or_zero ? "0 or " : "") + "a " +
                                        (kWhole ? "whole " : "") + "number from " + plain(range.low) + " to " +
                                        plain(range.high));
            }
            config.*field = static_cast<Number>(*value);
          },
          [=](const Config& config) { return plain(static_cast<double>(config.*field)); }};
}

Key flag_key(std::string name, std::string comment, bool Config::*field) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config, const Complain& complain) {
            const auto value = node.value_exact<bool>();
            if (!value) return complain(node, "expected true or false");
            config.*field = *value;
          },
          [=](const Config& config) { return std::string(config.*field ? "true" : "false"); }};
}

Key mode_key() {
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

// In the order in which they are printed.
const std::vector<Key>& all_keys() {
  static const std::vector<Key> keys = {
      text_key("camera", "libcamera:0, v4l2:/dev/video0?width=1280&height=720&fps=30, folder:DIR, scene:NAME",
               &Config::camera, check_camera),
      text_key("button",
               "gpiod:name=LINE or gpiod:gpiochip0/17 with ?active_low=yes&bias=pull-up&debounce_ms=30, "
               "script:FILE, keyboard:",
               &Config::button, check_button),
      list_key("status", "any of lcm:udpm://239.255.76.67:7667?ttl=0, led:name=LINE, console:", &Config::status,
               check_status),
      text_key("output", "folder of the captures and panoramas", &Config::output, check_output),
      text_key("device_name", "as written into captures", &Config::device_name),
      mode_key(),
      number_key("sweep.overlap", "of neighbouring frames", &Config::overlap, {0.3, 0.95}),
      number_key("sweep.max_frames", "the sweep ends after so many", &Config::max_frames, {3, 1000}),
      number_key("sweep.max_seconds", "the sweep ends after so long", &Config::max_seconds, {1, 3600}),
      number_key("sweep.min_frames", "a sweep with fewer is not built", &Config::min_frames, {3, 1000}),
      number_key("sweep.arm_length_m", "from the axis of the turn to the camera", &Config::arm_length_m, {0.05, 10}),
      number_key("sweep.fov_degrees", "horizontal field of view; 0 = unknown, it is then estimated",
                 &Config::fov_degrees, {0, 170}),
      number_key("sweep.lost_after_seconds", "without a frame the camera counts as lost", &Config::lost_after_seconds,
                 {0.2, 60}),
      number_key("sweep.reserve_mib", "of the disk that are never filled", &Config::reserve_mib, {0, 1e6}),
      flag_key("build.follow", "whether poses are found while the arm still moves", &Config::follow),
      text_key("build.program", "empty: the ldp beside ldpd", &Config::program, check_program),
      number_key("build.threads", "0 = all cores", &Config::threads, {0, 256}),
      number_key("build.memory_limit_mib", "of the build's process, at least 64; 0 = none", &Config::memory_limit_mib,
                 {kLeastMemoryLimit_mib, 1e6}, true),
      number_key("build.niceness", "0 = as important as everything else, 19 = least", &Config::niceness, {0, 19}),
      list_key("build.options", "further options of ldp build", &Config::options),
  };
  return keys;
}

int line_of(const toml::source_region& source) { return static_cast<int>(source.begin.line); }

class Reader {
 public:
  explicit Reader(CheckedConfig& checked) : checked_(checked) {
    for (const Key& key : all_keys()) keys_[key.name] = &key;
  }

  void read_all(const toml::table& table, Inputs inputs) {
    read(table, "");
    const Config& config = checked_.config;
    const std::string wrong = are_right({"button", "sweep.mode"}) ? wrong_mode(config) : "";
    if (!wrong.empty()) checked_.mistakes.push_back({lines_["sweep.mode"], "sweep.mode: " + wrong});
    if (inputs == Inputs::must_exist) {
      check_input("camera", check_camera_is_there, config.camera);
      check_input("button", check_button_is_there, config.button);
    }
    if (are_right({"sweep.max_frames", "sweep.min_frames"}) && config.max_frames < config.min_frames) {
      checked_.mistakes.push_back({std::max(lines_["sweep.max_frames"], lines_["sweep.min_frames"]),
                                   "sweep.max_frames is smaller than sweep.min_frames"});
    }
  }

 private:
  void read(const toml::table& table, const std::string& prefix) {
    for (const auto& [name, node] : table) {
      const std::string full = prefix + std::string(name.str());
      const toml::table* const section = node.as_table();
      if (section != nullptr && prefix.empty() && (full == "sweep" || full == "build")) {
        read(*section, full + ".");
        continue;
      }
      const auto key = keys_.find(full);
      if (key == keys_.end()) {
        add(name.source(), "unknown " + std::string(section != nullptr ? "section" : "key") + " '" + full + "'");
        continue;
      }
      lines_[full] = line_of(node.source());
      key->second->read(node, checked_.config, [&](const toml::node& where, const std::string& what) {
        add(where.source(), full + ": " + what);
        wrong_.insert(full);
      });
    }
  }

  // Values that could not be read would be compared as their defaults.
  bool are_right(std::initializer_list<const char*> keys) const {
    return std::none_of(keys.begin(), keys.end(), [this](const char* key) { return wrong_.contains(key); });
  }

  void check_input(const char* key, Check check, const std::string& url) {
    const std::string missing = are_right({key}) ? complaint_of(check, url) : "";
    if (!missing.empty()) checked_.mistakes.push_back({lines_[key], std::string(key) + ": " + missing});
  }

  void add(const toml::source_region& source, std::string text) {
    checked_.mistakes.push_back({line_of(source), std::move(text)});
  }

  CheckedConfig& checked_;
  std::map<std::string, const Key*> keys_;
  std::map<std::string, int> lines_;  // of the keys that are there
  std::set<std::string> wrong_;       // of them, those whose values are mistakes
};

}  // namespace

ButtonMode mode_of(const Config& config) {
  return config.mode.value_or(can_be_held(config.button) ? ButtonMode::hold : ButtonMode::toggle);
}

std::filesystem::path program_of(const Config& config) {
  if (!config.program.empty()) return config.program;
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "ldp";
}

std::vector<ConfigMistake> wrong_values(const Config& config, Inputs inputs) {
  std::vector<ConfigMistake> mistakes;
  const auto add = [&](const std::string& name, const std::string& wrong) {
    if (!wrong.empty()) mistakes.push_back({0, name + ": " + wrong});
  };
  const bool must_exist = inputs == Inputs::must_exist;
  add("camera", complaint_of(must_exist ? check_camera_is_there : check_camera, config.camera));
  add("button", complaint_of(must_exist ? check_button_is_there : check_button, config.button));
  add("mode", wrong_mode(config));
  for (const std::string& status : config.status) add("status", complaint_of(check_status, status));
  add("output", complaint_of(check_output, config.output));
  return mistakes;
}

CheckedConfig parse_config(const std::string& toml_text, Inputs inputs) {
  CheckedConfig checked;
  try {
    const toml::table table = toml::parse(toml_text);
    Reader(checked).read_all(table, inputs);
  } catch (const toml::parse_error& error) {
    checked.mistakes.push_back({line_of(error.source()), std::string(error.description())});
  }
  std::stable_sort(checked.mistakes.begin(), checked.mistakes.end(),
                   [](const ConfigMistake& a, const ConfigMistake& b) { return a.line < b.line; });
  return checked;
}

CheckedConfig read_config(const std::filesystem::path& file, Inputs inputs) {
  std::ifstream in(file);
  in.peek();  // a folder fails here; an empty file is a good one
  if (!in.is_open() || in.bad()) return {{}, {{0, "cannot read the file"}}};
  std::ostringstream text;
  text << in.rdbuf();
  return parse_config(text.str(), inputs);
}

std::string config_text(const Config& config) {
  std::string text, section;
  for (const Key& key : all_keys()) {
    const size_t dot = key.name.find('.');
    const std::string in_section = dot == std::string::npos ? "" : key.name.substr(0, dot);
    if (in_section != section) text += "\n[" + in_section + "]\n";
    section = in_section;
    text += "# " + key.comment + "\n";
    text += key.name.substr(dot == std::string::npos ? 0 : dot + 1) + " = " + key.write(config) + "\n";
  }
  return text;
}

}  // namespace ldp
