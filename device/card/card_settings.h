// What a person writes into camera.toml on the card's boot partition, on any computer, before the camera is switched
// on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "device/service/config/config.h"

namespace ldp {

// How the camera is reached: not at all, by cable, in a network that is there, or in its own.
enum class Network : uint8_t { none, cable, wifi, access_point };

struct CardSettings {
  std::string name = "panorama";  // in the network: NAME.local
  std::string camera = "v4l2:/dev/video0?width=1280&height=720&fps=30";
  double arm_length_m = 0.65;
  std::string effort = "standard";
  bool gallery = true;  // served where there is a network

  // GPIO lines: "gpiochip0/17", or any name that gpioinfo lists.
  std::string button_line = "gpiochip0/17";
  ButtonMode button_mode = ButtonMode::hold;
  double switch_off_s = 8;                // held so long without turning; 0 = never
  std::string led_line = "gpiochip0/27";  // empty: no LED

  Network network = Network::none;
  std::string ssid;      // 1 to 32 bytes
  std::string password;  // 8 to 63 characters of ASCII
  std::string country;   // two capital letters: which channels the radio may use
  std::string ssh_key;   // public, a line of OpenSSH's: who holds the other half may log in; empty: nobody
};

struct CheckedCard {
  bool there = true;                    // false: there is no such file, the defaults hold
  CardSettings settings;                // what is a mistake holds as if it had been left out, and so what stands below
                                        // a line that is no TOML
  std::vector<ConfigMistake> mistakes;  // in the order of the file
};

CheckedCard parse_card(const std::string& toml_text);

std::string button_url(const CardSettings& settings);
std::string led_url(const CardSettings& settings);  // empty: no LED

}  // namespace ldp
