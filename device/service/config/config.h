// What ldpd is told: one TOML file, every mistake in it named with its line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "device/service/session_state.h"

namespace ldp {

// What the service's configuration, and a card's, may say.
inline constexpr double kLeastArm_m = 0.05, kLongestArm_m = 10;
inline constexpr double kLeastSwitchOff_s = 4, kMostSwitchOff_s = 60;  // or 0

struct Config {
  std::string camera = "libcamera:0";
  std::string button = "gpiod:name=capture-button?active_low=yes&bias=pull-up";
  std::vector<std::string> status = {"console:"};
  std::string output = "/var/lib/ldpd";
  std::string device_name = "layered-depth-panorama camera";
  double switch_off_s = 0;  // a press that lasts so long, while the camera stands still, switches off; 0 = none does

  // [sweep]
  std::optional<ButtonMode> mode;  // none: what the button can, see mode_of
  double overlap = 0.75;           // of neighbouring frames
  int max_frames = 80;
  double max_seconds = 60;
  int min_frames = 4;  // fewer are not built
  double arm_length_m = 0.65;
  double fov_degrees = 0;         // horizontal, 0 = unknown
  double lost_after_seconds = 3;  // without a frame the camera counts as lost
  int reserve_mib = 64;           // of the disk, never filled

  // [build]
  bool follow = true;   // poses are found while the arm moves
  std::string program;  // empty: ldp beside ldpd
  std::string effort = "standard";
  int threads = 0;             // 0 = all
  int memory_limit_mib = 512;  // of the process, at least 64, 0 = none
  int niceness = 10;
  std::vector<std::string> options;
};

struct ConfigMistake {
  int line = 0;  // 0: none
  std::string text;
};

struct CheckedConfig {
  Config config;                        // good only without mistakes
  std::vector<ConfigMistake> mistakes;  // in the order of the file
};

// The folder of a folder: camera and the file of a script: button. A service that starts waits for them, a
// single run does not.
enum class Inputs : uint8_t { may_be_missing, must_exist };

// The mode that was given, otherwise hold where the button tells when it is let go, and toggle where it does not.
ButtonMode mode_of(const Config& config);

// The program that was given, otherwise ldp beside this one.
std::filesystem::path program_of(const Config& config);

// What the command line, too, can say wrongly: the URLs of the devices, a mode that the button cannot do, the output
// folder; line 0. Devices need not be there, and no network be up.
std::vector<ConfigMistake> wrong_values(const Config& config, Inputs inputs = Inputs::may_be_missing);

CheckedConfig parse_config(const std::string& toml_text, Inputs inputs = Inputs::may_be_missing);
CheckedConfig read_config(const std::filesystem::path& file, Inputs inputs = Inputs::may_be_missing);

std::string config_text(const Config& config);  // as TOML, comments included; parse_config gives it back

}  // namespace ldp
