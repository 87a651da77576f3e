#include "device/card/card_files.h"

#include <array>
#include <cstdio>

namespace ldp {
namespace {

// The camera's own network: an address of its own, others are given out.
constexpr const char* kOwnAddress = "192.168.77.1/24";
constexpr int kOwnChannel_mhz = 2437;  // 6, allowed everywhere
// The service and the gallery speak with each other on this machine alone: the group has no way out, and the service
// hears only addresses of this machine's own (root/etc/systemd/system/ldpd.service.d).
constexpr const char* kStatusUrl = "lcm:udpm://239.255.76.67:7667?ttl=0";
constexpr const char* kLoopback =
    "[Match]\nName=lo\n\n[Route]\nDestination=224.0.0.0/4\nScope=link\nPreferredSource=127.0.0.1\n";
// The clock's servers come with the address; the camera's identity is its card's, for its machine id is of one start.
constexpr const char* kFromOthers =
    "\n[Network]\nDHCP=yes\nLLMNR=no\n\n[DHCPv4]\nClientIdentifier=mac\nUseHostname=no\n";

bool is_wireless(Network network) { return network == Network::wifi || network == Network::access_point; }

std::string hex(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) {
    std::array<char, 3> two{};
    std::snprintf(two.data(), two.size(), "%02x", static_cast<unsigned char>(byte));
    text += two.data();
  }
  return text;
}

Config service_config(const CardSettings& settings) {
  Config config;
  config.camera = settings.camera;
  config.button = button_url(settings);
  config.mode = settings.button_mode;
  config.switch_off_s = settings.switch_off_s;
  config.arm_length_m = settings.arm_length_m;
  config.effort = settings.effort;
  config.device_name = settings.name;
  if (const std::string led = led_url(settings); !led.empty()) config.status.push_back(led);
  if (settings.gallery && settings.network != Network::none) config.status.emplace_back(kStatusUrl);
  return config;
}

// Quotes within the password are its own: the last one ends it.
std::string radio_text(const CardSettings& settings) {
  std::string text = "country=" + settings.country + "\nnetwork={\n  ssid=" + hex(settings.ssid) + "\n";
  if (settings.network == Network::access_point) {
    text += "  mode=2\n  frequency=" + std::to_string(kOwnChannel_mhz) + "\n  proto=RSN\n  pairwise=CCMP\n";
  } else {
    text += "  scan_ssid=1\n";
  }
  return text + "  key_mgmt=WPA-PSK\n  psk=\"" + settings.password + "\"\n}\n";
}

std::string link_text(Network network) {
  if (network == Network::access_point)
    return std::string("[Match]\nName=wlan*\n\n[Network]\nAddress=") + kOwnAddress +
           "\nDHCPServer=yes\nLLMNR=no\nIPv6AcceptRA=no\n\n[DHCPServer]\nEmitDNS=no\nEmitRouter=no\n";
  return std::string("[Match]\nName=") + (network == Network::wifi ? "wlan*" : "en* eth*") + "\n" + kFromOthers;
}

}  // namespace

std::vector<CardFile> card_files(const CardSettings& settings) {
  std::vector<CardFile> files = {{"ldpd.toml", config_text(service_config(settings))},
                                 {"hostname", settings.name + "\n"}};
  if (settings.network == Network::none) return files;
  files.push_back({"network/10-loopback.network", kLoopback});
  files.push_back({"network/20-camera.network", link_text(settings.network)});
  if (is_wireless(settings.network)) files.push_back({"wpa_supplicant.conf", radio_text(settings), true});
  if (settings.gallery) files.push_back({"gallery", ""});
  if (!settings.ssh_key.empty()) files.push_back({"authorized_keys", settings.ssh_key + "\n"});
  return files;
}

std::string card_report(const CheckedCard& checked, const std::string& version) {
  const std::string programs = "The camera's programs are of version " + version + ".\n";
  if (!checked.there)
    return "There is no camera.toml here (is it called camera.toml.txt?): the camera uses what it was made with.\n" +
           programs;
  if (checked.mistakes.empty()) return "camera.toml was read without a mistake.\n" + programs;
  std::string text = "The camera does not start, for camera.toml has mistakes:\n\n";
  for (const ConfigMistake& mistake : checked.mistakes)
    text += "line " + std::to_string(mistake.line) + ": " + mistake.text + "\n";
  return text + "\nMend them with any text editor, then switch the camera on again.\n" + programs;
}

}  // namespace ldp
