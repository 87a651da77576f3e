#include "device/service/config/config.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "device/backends/open.h"
#include "device/service/config/config_checks.h"
#include "device/service/config/config_keys.h"

namespace ldp {
namespace {

int line_of(const toml::source_region& source) { return static_cast<int>(source.begin.line); }

class Reader {
 public:
  explicit Reader(CheckedConfig& checked) : checked_(checked) {
    for (const ConfigKey& key : all_config_keys()) keys_[key.name] = &key;
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
        add(where.source(), std::string(full).append(": ").append(what));
        wrong_.insert(full);
      });
    }
  }

  // Values that could not be read would be compared as their defaults.
  bool are_right(std::initializer_list<const char*> keys) const {
    return std::none_of(keys.begin(), keys.end(), [this](const char* key) { return wrong_.contains(key); });
  }

  void check_input(const char* key, TextCheck check, const std::string& url) {
    const std::string missing = are_right({key}) ? complaint_of(check, url) : "";
    if (!missing.empty()) checked_.mistakes.push_back({lines_[key], std::string(key) + ": " + missing});
  }

  void add(const toml::source_region& source, std::string text) {
    checked_.mistakes.push_back({line_of(source), std::move(text)});
  }

  CheckedConfig& checked_;
  std::map<std::string, const ConfigKey*> keys_;
  std::map<std::string, int> lines_;  // of the keys that are there
  std::set<std::string> wrong_;       // of them, those whose values are mistakes
};

}  // namespace

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
  add("output", complaint_of(check_output_folder, config.output));
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
  if (!in.is_open() || in.bad())
    return {{}, {{0, "cannot read the file (" + std::string(std::strerror(errno)) + "): check its name"}}};
  std::ostringstream text;
  text << in.rdbuf();
  return parse_config(text.str(), inputs);
}

std::string config_text(const Config& config) {
  std::string text, section;
  for (const ConfigKey& key : all_config_keys()) {
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
