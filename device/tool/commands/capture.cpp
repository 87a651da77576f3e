// ldp capture: one sweep into a capture folder, by the capture service's own code.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/captures/field_of_view.h"
#include "core/captures/json_text.h"
#include "device/service/capture_session.h"
#include "device/service/reasons.h"
#include "device/tool/commands.h"
#include "device/tool/number_within.h"
#include "device/tool/process/interrupt.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

struct CaptureCommand {
  Config config;
  std::string mode;  // empty: not given
};

void refuse_used_folder(const std::string& folder) {
  if (folder.empty()) throw BadInput("no output folder is named: add -o DIR");
  if (!std::filesystem::exists(folder)) return;
  if (!std::filesystem::is_directory(folder)) throw BadInput(folder + ": is a file: name a new folder");
  if (!std::filesystem::is_empty(folder)) throw BadInput(folder + ": is not empty: name a new folder");
}

// The output folder of a capture that may come to nothing: where no frame was kept, it and the folders made for it go
// again, and half a frame in any case. The folder must be new or empty.
class NewFolder {
 public:
  explicit NewFolder(const std::string& folder) : when_cut_off_([this] { tidy(); }) {
    for (fs::path missing = fs::absolute(folder); !fs::exists(missing); missing = missing.parent_path()) {
      made_.push_back(missing);
    }
    folder_ = folder;
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  ~NewFolder() { tidy(); }
  void keep_nothing() { keeps_frames_ = false; }

 private:
  void tidy() const {
    std::error_code error;
    std::vector<fs::path> unwanted;
    bool has_frames = false;
    for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
      const bool is_frame = entry->path().extension() == ".jpg";
      has_frames = has_frames || (is_frame && keeps_frames_);
      if (entry->path().extension() == ".tmp" || (is_frame && !keeps_frames_)) unwanted.push_back(entry->path());
    }
    for (const fs::path& file : unwanted) fs::remove(file, error);
    if (has_frames) return;
    fs::remove(folder_ / "capture.json", error);
    for (const fs::path& made : made_) fs::remove(made, error);  // innermost first; none that holds anything else
  }

  fs::path folder_;
  std::vector<fs::path> made_;
  bool keeps_frames_ = true;
  WhenCutOff when_cut_off_;
};

[[noreturn]] void refuse(const Reason& failure) {
  if (failure.why == Why::no_room || is_machine_fault(failure.code)) throw MachineFault(text_of(failure));
  throw Impossible(text_of(failure));
}

int run_capture(CaptureCommand command, const Session& session) {
  Config& config = command.config;
  refuse_used_folder(config.output);
  if (!command.mode.empty()) config.mode = command.mode == "hold" ? ButtonMode::hold : ButtonMode::toggle;
  config.min_frames = std::min(config.min_frames, config.max_frames);
  for (const ConfigMistake& mistake : wrong_values(config)) throw BadInput("--" + mistake.text);
  std::optional<Unhurried> unhurried;
  NewFolder folder(config.output);
  try {
    CaptureSession capture(config, Run::capture_only, session.stop);
    unhurried.emplace();  // opening a camera is given up at once; a sweep is stored first
    const int status = capture.run();
    if (capture.frames_stored() == 0) folder.keep_nothing();
    if (session.stop.stop_requested()) return kInterrupted;
    if (status != kDone) refuse(capture.last_failure());
    if (session.json) {
      const nlohmann::ordered_json json{{"capture", config.output}, {"frames", capture.frames_stored()}};
      std::printf("%s\n", json_text(json).c_str());
    }
    return kDone;
  } catch (const UnusableDevice& error) {
    throw BadInput(error.what());
  }
}

}  // namespace

void add_capture(Program& program) {
  auto command = std::make_shared<CaptureCommand>();
  Config& config = command->config;
  config.output.clear();
  config.camera = "libcamera:0";
  config.button = "keyboard:";
  CLI::App& app = add_command(program, "capture", "One sweep of a camera into a capture folder",
                              [command](const Session& session) { return run_capture(*command, session); });
  app.add_option("--camera", config.camera, "libcamera:0, v4l2:/dev/video0, folder:DIR?fps=30, scene:NAME?fps=30")
      ->capture_default_str();
  app.add_option("--button", config.button, "gpiod:name=LINE, gpiod:gpiochip0/17, script:FILE, keyboard:")
      ->capture_default_str();
  app.add_option("--status", config.status,
                 "lcm:udpm://239.255.76.67:7667?ttl=0, led:name=LINE, console:; several allowed");
  app.add_option("-o,--output", config.output, "Folder to make");
  app.add_option("--mode", command->mode,
                 "hold: while the button is held; toggle: press to begin, press to end; by default what the button can")
      ->check(CLI::IsMember({"hold", "toggle"}));
  app.add_option("--overlap", config.overlap, "Of neighbouring frames")
      ->check(number_within(0.3, 0.95))
      ->capture_default_str();
  app.add_option("--max-frames", config.max_frames, "The sweep ends after so many")
      ->check(whole_within(3, 1000))
      ->capture_default_str();
  app.add_option("--max-seconds", config.max_seconds, "The sweep ends after so long")
      ->check(number_within(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--fov", config.fov_degrees, "Horizontal field of view, degrees; 0 = unknown")
      ->check(zero_or_within(kLeastFov_deg, kMostFov_deg))
      ->capture_default_str();
}

}  // namespace ldp
