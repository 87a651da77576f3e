#include "config.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "url.h"

namespace ldp {
namespace {

constexpr const char* kCameras = "libcamera v4l2 folder scene";
constexpr const char* kButtons = "gpiod script keyboard";
constexpr const char* kStatuses = "lcm led console";

bool is_among(const std::string& word, const char* words) {
  std::istringstream in(words);
  for (std::string candidate; in >> candidate;) {
    if (candidate == word) return true;
  }
  return false;
}

bool can_be_held(const std::string& button) { return !button.starts_with("keyboard:"); }

// Empty = good. Only a mode that was given can be wrong.
std::string wrong_mode(const Config& config) {
  if (config.mode != ButtonMode::hold || can_be_held(config.button)) return {};
  return "a terminal does not tell when a key is let go: keyboard: needs the mode toggle";
}

struct Key {
  std::string name;  // "sweep.overlap"
  std::string comment;
  std::function<std::string(const toml::node&, Config&)> read;  // empty = good, else what is expected
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

std::string wrong_url(const std::string& text, const char* schemes) {
  try {
    const Url url(text);
    if (is_among(url.scheme(), schemes)) return {};
    return "unknown kind '" + url.scheme() + ":'; known: " + schemes;
  } catch (const std::exception& error) {
    return error.what();
  }
}

Key text_key(std::string name, std::string comment, std::string Config::*field, const char* schemes = nullptr) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config) -> std::string {
            const auto value = node.value_exact<std::string>();
            if (!value) return "expected a text in quotes";
            config.*field = *value;
            return schemes == nullptr ? std::string() : wrong_url(*value, schemes);
          },
          [=](const Config& config) { return quoted(config.*field); }};
}

Key list_key(std::string name, std::string comment, std::vector<std::string> Config::*field,
             const char* schemes = nullptr) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config) -> std::string {
            const toml::array* const list = node.as_array();
            if (list == nullptr) return "expected a list of texts, as in [\"...\", \"...\"]";
            (config.*field).clear();
            for (const toml::node& entry : *list) {
              const auto value = entry.value_exact<std::string>();
              if (!value) return "expected only texts in quotes in the list";
              const std::string wrong = schemes == nullptr ? std::string() : wrong_url(*value, schemes);
              if (!wrong.empty()) return wrong;
              (config.*field).push_back(*value);
            }
            return {};
          },
          [=](const Config& config) { return quoted(config.*field); }};
}

template <typename Number>
Key number_key(std::string name, std::string comment, Number Config::*field, NumberRange range) {
  constexpr bool kWhole = std::is_integral_v<Number>;
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config) -> std::string {
            const auto value = kWhole && !node.is_integer() ? std::nullopt : node.value<double>();
            if (!value || !std::isfinite(*value) || *value < range.low || *value > range.high) {
              return std::string("expected a ") + (kWhole ? "whole " : "") + "number from " + plain(range.low) +
                     " to " + plain(range.high);
            }
            config.*field = static_cast<Number>(*value);
            return {};
          },
          [=](const Config& config) { return plain(static_cast<double>(config.*field)); }};
}

Key flag_key(std::string name, std::string comment, bool Config::*field) {
  return {std::move(name), std::move(comment),
          [=](const toml::node& node, Config& config) -> std::string {
            const auto value = node.value_exact<bool>();
            if (!value) return "expected true or false";
            config.*field = *value;
            return {};
          },
          [=](const Config& config) { return std::string(config.*field ? "true" : "false"); }};
}

Key mode_key() {
  return {"sweep.mode",
          "hold: the sweep lasts as long as the button is held; toggle: press to begin, press to end, 3 s cancel; "
          "left out: hold, with keyboard: toggle",
          [](const toml::node& node, Config& config) -> std::string {
            const auto value = node.value_exact<std::string>();
            if (value != "toggle" && value != "hold") return "expected \"toggle\" or \"hold\"";
            config.mode = value == "hold" ? ButtonMode::hold : ButtonMode::toggle;
            return {};
          },
          [](const Config& config) {
            return quoted(std::string(mode_of(config) == ButtonMode::hold ? "hold" : "toggle"));
          }};
}

// In the order in which they are printed.
const std::vector<Key>& all_keys() {
  static const std::vector<Key> keys = {
      text_key("camera", "libcamera:0, v4l2:/dev/video0?width=1280&height=720&fps=30, folder:DIR, scene:NAME",
               &Config::camera, kCameras),
      text_key("button",
               "gpiod:name=LINE or gpiod:gpiochip0/17 with ?active_low=yes&bias=pull-up&debounce_ms=30, "
               "script:FILE, keyboard:",
               &Config::button, kButtons),
      list_key("status", "any of lcm:udpm://239.255.76.67:7667?ttl=0, led:name=LINE, console:", &Config::status,
               kStatuses),
      text_key("output", "folder of the captures and panoramas", &Config::output),
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
      text_key("build.program", "empty: the ldp beside ldpd", &Config::program),
      number_key("build.threads", "0 = all cores", &Config::threads, {0, 256}),
      number_key("build.memory_limit_mib", "of the build's process; 0 = none", &Config::memory_limit_mib, {0, 1e6}),
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

  void read_all(const toml::table& table) {
    read(table, "");
    const std::string wrong = wrong_mode(checked_.config);
    if (!wrong.empty()) checked_.mistakes.push_back({mode_line_, "sweep.mode: " + wrong});
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
      if (full == "sweep.mode") mode_line_ = line_of(node.source());
      const std::string wrong = key->second->read(node, checked_.config);
      if (!wrong.empty()) add(node.source(), full + ": " + wrong);
    }
  }

  void add(const toml::source_region& source, std::string text) {
    checked_.mistakes.push_back({line_of(source), std::move(text)});
  }

  CheckedConfig& checked_;
  std::map<std::string, const Key*> keys_;
  int mode_line_ = 0;
};

}  // namespace

ButtonMode mode_of(const Config& config) {
  return config.mode.value_or(can_be_held(config.button) ? ButtonMode::hold : ButtonMode::toggle);
}

std::vector<ConfigMistake> wrong_devices(const Config& config) {
  std::vector<ConfigMistake> mistakes;
  const auto check = [&](const char* what, const std::string& url, const char* schemes) {
    const std::string wrong = wrong_url(url, schemes);
    if (!wrong.empty()) mistakes.push_back({0, std::string(what) + ": " + wrong});
  };
  check("camera", config.camera, kCameras);
  check("button", config.button, kButtons);
  const std::string wrong = wrong_mode(config);
  if (!wrong.empty()) mistakes.push_back({0, "mode: " + wrong});
  for (const std::string& status : config.status) check("status", status, kStatuses);
  return mistakes;
}

CheckedConfig parse_config(const std::string& toml_text) {
  CheckedConfig checked;
  try {
    const toml::table table = toml::parse(toml_text);
    Reader(checked).read_all(table);
  } catch (const toml::parse_error& error) {
    checked.mistakes.push_back({line_of(error.source()), std::string(error.description())});
  }
  const Config& config = checked.config;
  if (config.max_frames < config.min_frames) {
    checked.mistakes.push_back({0, "sweep.max_frames is smaller than sweep.min_frames"});
  }
  std::stable_sort(checked.mistakes.begin(), checked.mistakes.end(),
                   [](const ConfigMistake& a, const ConfigMistake& b) { return a.line < b.line; });
  return checked;
}

CheckedConfig read_config(const std::filesystem::path& file) {
  std::ifstream in(file);
  in.peek();  // a folder fails here; an empty file is a good one
  if (!in.is_open() || in.bad()) return {{}, {{0, "cannot read the file"}}};
  std::ostringstream text;
  text << in.rdbuf();
  return parse_config(text.str());
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
