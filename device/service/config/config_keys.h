// The keys of a configuration: how each is read, checked and written.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "device/service/config/config.h"
#include "device/service/config/toml_text.h"

namespace ldp {

using Complain = std::function<void(const toml::node& where, const std::string& what)>;

struct ConfigKey {
  std::string name;  // "sweep.overlap"
  std::string comment;
  std::function<void(const toml::node&, Config&, const Complain&)> read;
  std::function<std::string(const Config&)> write;
};

// In the order in which they are printed.
const std::vector<ConfigKey>& all_config_keys();

}  // namespace ldp
