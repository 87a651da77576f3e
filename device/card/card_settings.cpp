#include "device/card/card_settings.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "device/backends/open.h"
#include "device/service/config/config_checks.h"
#include "device/service/config/toml_text.h"

namespace ldp {
namespace {

constexpr std::array<std::pair<const char*, Network>, 4> kNetworks = {{{"none", Network::none},
                                                                       {"cable", Network::cable},
                                                                       {"wifi", Network::wifi},
                                                                       {"access-point", Network::access_point}}};
constexpr size_t kLongestName = 63;      // of a host, in DNS
constexpr size_t kMostBytes = 64 << 10;  // of the file
constexpr size_t kLongestKey = 4096;     // RSA of 16384 bits and a remark
constexpr size_t kLongestSsid = 32, kShortestPassword = 8, kLongestPassword = 63;

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

// What is wrong with a value, empty = nothing.
using Complaint = std::string;

Complaint wrong_name(const std::string& name) {
  const bool good = !name.empty() && name.size() <= kLongestName && name.front() != '-' && name.back() != '-' &&
                    std::all_of(name.begin(), name.end(), [](char c) { return is_letter_or_digit(c) || c == '-'; });
  return good ? "" : "expected 1 to 63 letters, digits and hyphens, as in 'panorama'";
}

Complaint wrong_ssid(const std::string& ssid) {
  const bool good = !ssid.empty() && ssid.size() <= kLongestSsid;
  return good ? "" : "expected the network's name, 1 to 32 characters";
}

Complaint wrong_password(const std::string& password) {
  const bool good = password.size() >= kShortestPassword && password.size() <= kLongestPassword &&
                    std::all_of(password.begin(), password.end(), [](char c) { return c >= ' ' && c <= '~'; });
  return good ? "" : "expected 8 to 63 characters without accents";
}

Complaint wrong_country(const std::string& country) {
  const bool good =
      country.size() == 2 && std::all_of(country.begin(), country.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  return good ? "" : "expected two capital letters, as in 'DE'";
}

// Of base64 without line breaks; nothing where it is none.
std::optional<std::string> decoded(std::string_view base64) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (base64.size() % 4 != 0) return {};
  while (base64.ends_with('=')) base64.remove_suffix(1);
  std::string bytes;
  uint32_t bits = 0;
  int count = 0;
  for (const char c : base64) {
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) return {};
    bits = bits << 6U | static_cast<uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 0xFFU);
  }
  return bytes;
}

// A public key is strings, each after its length in four bytes, the first of which is the key's kind (RFC 4253, 6.6).
bool is_public_key(const std::string& kind, std::string_view bytes) {
  for (int parts = 0;; ++parts) {
    if (bytes.empty()) return parts > 1;
    if (bytes.size() < 4) return false;
    size_t length = 0;
    for (const char c : bytes.substr(0, 4)) length = length << 8U | static_cast<uint8_t>(c);
    if (length > bytes.size() - 4 || (parts == 0 && bytes.substr(4, length) != kind)) return false;
    bytes.remove_prefix(4 + length);
  }
}

// One line as ssh-keygen writes it, without options before the kind.
Complaint wrong_ssh_key(const std::string& key) {
  static constexpr std::array kKinds = {"ssh-ed25519",
                                        "ssh-rsa",
                                        "ecdsa-sha2-nistp256",
                                        "ecdsa-sha2-nistp384",
                                        "ecdsa-sha2-nistp521",
                                        "sk-ssh-ed25519@openssh.com",
                                        "sk-ecdsa-sha2-nistp256@openssh.com"};
  if (key.empty()) return "";
  std::istringstream words(key);
  std::string kind, base64;
  words >> kind >> base64;
  const auto bytes = decoded(base64);
  const bool good = std::find(kKinds.begin(), kKinds.end(), kind) != kKinds.end() && bytes &&
                    is_public_key(kind, *bytes) && key.size() <= kLongestKey &&
                    key.find_first_of("\r\n") == std::string::npos;
  return good ? "" : "expected the one line of a public key, whole, as id_ed25519.pub holds: 'ssh-ed25519 AAAA... you'";
}

std::string line_url(const char* scheme, const std::string& line) {
  return scheme + (line.find('/') == std::string::npos ? "name=" + line : line);
}

// A line's name goes into a URL, whose own signs it must not hold.
Complaint wrong_line(const std::string& line) {
  const bool good = !line.empty() && line.find_first_of("?&= ") == std::string::npos;
  return good ? "" : "expected the GPIO line's number, as in 17, or its name, as in 'GPIO17' or 'gpiochip1/4'";
}

Complaint wrong_button(const std::string& line) {
  Complaint wrong = wrong_line(line);
  return wrong.empty() ? complaint_of(check_button, line_url("gpiod:", line)) : wrong;
}

Complaint wrong_led(const std::string& line) {
  const Complaint wrong = line.empty() ? "" : wrong_line(line);
  return wrong.empty() && !line.empty() ? complaint_of(check_status, line_url("led:", line)) : wrong;
}

class CardReader {
 public:
  explicit CardReader(CheckedCard& checked) : checked_(checked), settings_(checked.settings) { declare(); }

  void read_all(const toml::table& table) {
    read(table, "");
    check_network();
    check_lines();
  }

 private:
  using Check = std::function<Complaint(const std::string&)>;

  void declare() {
    text("name", settings_.name, wrong_name);
    text("camera", settings_.camera, [](const std::string& url) { return complaint_of(check_camera, url); });
    text("effort", settings_.effort, [](const std::string& name) { return complaint_of(check_effort, name); });
    number("arm_length_m", settings_.arm_length_m, "expected metres, a number from 0.05 to 10",
           [](double metres) { return metres >= kLeastArm_m && metres <= kLongestArm_m; });
    keys_["gallery"] = [this](const toml::node& node) {
      const auto value = node.value_exact<bool>();
      settings_.gallery = value.value_or(settings_.gallery);
      return Complaint(value ? "" : "expected true or false");
    };
    line("button.line", settings_.button_line, wrong_button);
    word("button.mode", "expected 'hold' or 'toggle'", [this](const std::string& mode) {
      settings_.button_mode = mode == "toggle" ? ButtonMode::toggle : ButtonMode::hold;
      return mode == "toggle" || mode == "hold";
    });
    number(
        "button.switch_off_s", settings_.switch_off_s, "expected seconds, 0 or a number from 4 to 60",
        [](double seconds) { return seconds == 0 || (seconds >= kLeastSwitchOff_s && seconds <= kMostSwitchOff_s); });
    line("led.line", settings_.led_line, wrong_led);
    word("network.kind", "expected 'none', 'cable', 'wifi' or 'access-point'", [this](const std::string& kind) {
      const auto found =
          std::find_if(kNetworks.begin(), kNetworks.end(), [&](const auto& one) { return kind == one.first; });
      if (found != kNetworks.end()) settings_.network = found->second;
      return found != kNetworks.end();
    });
    text("network.ssid", settings_.ssid, wrong_ssid);
    text("network.password", settings_.password, wrong_password);
    text("network.country", settings_.country, wrong_country);
    text("network.ssh_key", settings_.ssh_key, wrong_ssh_key);
  }

  void read(const toml::table& table, const std::string& prefix) {
    for (const auto& [name, node] : table) {
      const std::string full = prefix + std::string(name.str());
      const toml::table* const section = node.as_table();
      if (prefix.empty() && (full == "button" || full == "led" || full == "network")) {
        if (section != nullptr) {
          read(*section, full + ".");
        } else {
          add(line_of(name), "'" + full + "' is a section: write [" + full + "], and its settings below");
        }
        continue;
      }
      const auto key = keys_.find(full);
      if (key == keys_.end()) {
        add(line_of(name), "unknown " + std::string(section != nullptr ? "section" : "key") + " '" + full + "'");
        continue;
      }
      lines_[full] = line_of(name);
      const Complaint wrong = key->second(node);
      if (!wrong.empty()) add(lines_[full], full + ": " + wrong);
    }
  }

  // A password without a network's name, or the other way round.
  void check_network() {
    const bool wireless = settings_.network == Network::wifi || settings_.network == Network::access_point;
    for (const char* key : {"network.ssid", "network.password", "network.country"}) {
      const bool given = lines_.contains(key);
      const char* const name = key + std::string_view("network.").size();
      if (wireless && !given) add(lines_["network.kind"], std::string("network.") + name + " is missing");
      if (!wireless && given && !is_wrong("network.kind"))
        add(lines_[key], std::string(key) + ": is for network.kind = 'wifi' or 'access-point'");
    }
    if (settings_.network == Network::none && !settings_.ssh_key.empty() && !is_wrong("network.kind"))
      add(lines_["network.ssh_key"], "network.ssh_key: there is no network to log in by: choose a network.kind");
  }

  void check_lines() {
    if (!is_wrong("button.line") && !is_wrong("led.line") && settings_.button_line == settings_.led_line)
      add(lines_[lines_.contains("button.line") ? "button.line" : "led.line"],
          "button.line and led.line are both " + settings_.button_line + ": choose another for one of them");
  }

  void text(const char* key, std::string& field, const Check& check) {
    keys_[key] = [&field, check](const toml::node& node) {
      const auto value = node.value_exact<std::string>();
      if (!value) return Complaint("expected a text in quotes");
      Complaint wrong = check(*value);
      if (wrong.empty()) field = *value;
      return wrong;
    };
  }

  // A GPIO line by its number, which on boards with such a header is that of the first chip's, or by a name: not all
  // lines have one.
  void line(const char* key, std::string& field, const Check& check) {
    keys_[key] = [&field, check](const toml::node& node) {
      const auto number = node.value_exact<int64_t>();
      const auto value = number ? "gpiochip0/" + std::to_string(*number) : node.value_exact<std::string>();
      Complaint wrong = !value || number.value_or(0) < 0 ? wrong_line("") : check(*value);
      if (wrong.empty()) field = *value;
      return wrong;
    };
  }

  void word(const char* key, const char* expected, const std::function<bool(const std::string&)>& keep) {
    keys_[key] = [expected, keep](const toml::node& node) {
      const auto value = node.value_exact<std::string>();
      return Complaint(value && keep(*value) ? "" : expected);
    };
  }

  void number(const char* key, double& field, const char* expected, const std::function<bool(double)>& good) {
    keys_[key] = [&field, expected, good](const toml::node& node) {
      const auto value = node.value<double>();
      if (!value || !good(*value)) return Complaint(expected);
      field = *value;
      return Complaint();
    };
  }

  static int line_of(const toml::key& name) { return static_cast<int>(name.source().begin.line); }

  bool is_wrong(const std::string& key) const {
    return std::any_of(checked_.mistakes.begin(), checked_.mistakes.end(),
                       [&](const ConfigMistake& mistake) { return mistake.text.starts_with(key + ":"); });
  }

  void add(int line, std::string text) { checked_.mistakes.push_back({line, std::move(text)}); }

  CheckedCard& checked_;
  CardSettings& settings_;
  std::map<std::string, std::function<Complaint(const toml::node&)>> keys_;
  std::map<std::string, int> lines_;  // of the keys that are there
};

std::string first_lines(const std::string& text, int lines) {
  size_t end = std::string::npos;  // after which is the first character
  while (lines-- > 0) end = text.find('\n', end + 1);
  return text.substr(0, end);
}

}  // namespace

std::string button_url(const CardSettings& settings) {
  return line_url("gpiod:", settings.button_line) + "?active_low=yes&bias=pull-up";
}

std::string led_url(const CardSettings& settings) {
  return settings.led_line.empty() ? "" : line_url("led:", settings.led_line);
}

CheckedCard parse_card(const std::string& toml_text) {
  CheckedCard checked;
  if (toml_text.size() > kMostBytes) {
    checked.mistakes.push_back({1, "the file is larger than 64 KiB: it is no camera.toml"});
    return checked;
  }
  if (toml_text.starts_with("\xFF\xFE") || toml_text.starts_with("\xFE\xFF")) {
    checked.mistakes.push_back({1, "the file is in UTF-16: save it again as UTF-8 text"});
    return checked;
  }
  try {
    const toml::table table = toml::parse(toml_text);
    CardReader(checked).read_all(table);
  } catch (const toml::parse_error& error) {
    const int line = static_cast<int>(error.source().begin.line);
    if (line > 1) checked.settings = parse_card(first_lines(toml_text, line - 1)).settings;
    std::string text(error.description());
    if (text.find("parsing value") != std::string::npos || text.find(" string:") != std::string::npos)
      text += "; a text stands in quotes, on one line";
    checked.mistakes = {{line, std::move(text)}};
  }
  std::stable_sort(checked.mistakes.begin(), checked.mistakes.end(),
                   [](const ConfigMistake& a, const ConfigMistake& b) { return a.line < b.line; });
  return checked;
}

}  // namespace ldp
