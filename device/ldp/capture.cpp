// ldp capture: one sweep into a capture folder. ldp watch: what a device tells. Both share the capture service's code.

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "capture_session.h"
#include "clocks.h"
#include "commands.h"
#include "status.h"
#include "unique_fd.h"

namespace ldp {
namespace {

constexpr const char* kLcm = "lcm:udpm://239.255.76.67:7667?ttl=0";

// --- capture ---------------------------------------------------------------------------------------------------------

struct CaptureCommand {
  Config config;
  std::string mode = "hold";
};

void refuse_used_folder(const std::string& folder) {
  if (folder.empty()) throw BadInput("no output folder is named: add -o DIR");
  if (!std::filesystem::exists(folder)) return;
  if (!std::filesystem::is_directory(folder)) throw BadInput(folder + ": is a file: name a new folder");
  if (!std::filesystem::is_empty(folder)) throw BadInput(folder + ": is not empty: name a new folder");
}

int run_capture(CaptureCommand command, const Session& session) {
  Config& config = command.config;
  refuse_used_folder(config.output);
  config.mode = command.mode == "hold" ? ButtonMode::hold : ButtonMode::toggle;
  CaptureSession capture(config, Run::capture_only, session.stop);
  const int status = capture.run();
  if (session.stop.stop_requested()) return kInterrupted;
  if (status != kDone) throw Impossible(capture.last_failure());
  if (session.json) {
    const nlohmann::ordered_json json{{"capture", config.output}, {"frames", capture.frames_stored()}};
    std::printf("%s\n", json.dump().c_str());
  }
  return kDone;
}

// --- watch -----------------------------------------------------------------------------------------------------------

struct WatchCommand {
  std::string url = kLcm, send;
  int count = 0;
};

using Json = nlohmann::ordered_json;

Json json_from(const Status& status) {
  return {{"type", "status"},
          {"phase", name_of(status.phase)},
          {"capture", status.capture},
          {"text", status.text},
          {"frames_stored", status.frames_stored},
          {"sweeps_left", status.sweeps_left}};
}
Json json_from(const Progress& progress) {
  return {{"type", "progress"}, {"capture", progress.capture}, {"stage", progress.stage}, {"fraction", progress.fraction}};
}
Json json_from(const Guidance& guidance) {
  return {{"type", "guidance"},
          {"advice", name_of(guidance.advice)},
          {"covered_rad", guidance.covered_rad},
          {"speed_rad_s", guidance.speed_rad_s},
          {"tilt_px", guidance.tilt_px},
          {"brightness", guidance.brightness},
          {"frames_chosen", guidance.frames_chosen}};
}
Json json_from(const Result& result) {
  return {{"type", "result"},       {"ok", result.ok},     {"capture", result.capture},
          {"file", result.file},    {"text", result.text}, {"seconds", result.seconds}};
}

std::string line_from(const Status& status) {
  return "status    " + std::string(name_of(status.phase)) + ": " + status.text + " (" + std::to_string(status.frames_stored) +
         " frames stored, " + std::to_string(status.sweeps_left) + " sweeps left)";
}
std::string line_from(const Progress& progress) {
  return "progress  " + progress.capture + " " + std::to_string(static_cast<int>(progress.fraction * 100)) + " % " +
         progress.stage;
}
std::string line_from(const Guidance& guidance) {
  char figures[128];
  std::snprintf(figures, sizeof figures, "%.0f degrees, %.0f degrees/s, %d frames", guidance.covered_rad * 57.29578,
                guidance.speed_rad_s * 57.29578, guidance.frames_chosen);
  return "guidance  " + std::string(name_of(guidance.advice)) + ": " + figures;
}
std::string line_from(const Result& result) {
  return "result    " + std::string(result.ok ? result.file : result.capture + " failed") + ": " + result.text;
}

void print(const HeardMessage& heard, bool as_json) {
  char utc[32];
  utc_text(heard.utc_ns, utc);
  if (as_json) {
    Json json = std::visit([](const auto& message) { return json_from(message); }, heard.message);
    json["utc"] = utc;
    json["monotonic_ns"] = heard.monotonic_ns;
    std::printf("%s\n", json.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
  } else {
    const std::string line = std::visit([](const auto& message) { return line_from(message); }, heard.message);
    std::string clean = line;  // a stranger's datagram must not write escape sequences onto the terminal
    for (char& c : clean) c = static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
    std::printf("%s  %s\n", utc, clean.c_str());
  }
  std::fflush(stdout);
}

Command command_from(const std::string& word) {
  for (const Command command : {Command::press, Command::release, Command::cancel, Command::retry}) {
    if (word == name_of(command)) return command;
  }
  throw BadInput("--send " + word + ": is not press, release, cancel or retry");
}

// Sleeps until something comes in or the program is to end; false at the end.
bool wait_for(int fd, int end_fd) {
  pollfd entries[] = {{fd, POLLIN, 0}, {end_fd, POLLIN, 0}};
  ::poll(entries, 2, -1);
  return entries[1].revents == 0;
}

int run_watch(const WatchCommand& command, const Session& session) {
  const auto listener = open_status_listener(command.url);
  if (!command.send.empty()) {
    listener->send(command_from(command.send));
    return kDone;
  }
  const UniqueFd end(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  const std::stop_callback on_stop(session.stop, [&end] {
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(end.get(), &one, sizeof one);
  });
  int printed = 0;
  bool going = true;
  while (going) {
    while (const auto heard = listener->read()) {
      print(*heard, session.json);
      if (++printed == command.count) return kDone;
    }
    going = !listener->ended() && wait_for(listener->fd(), end.get());
  }
  if (listener->ignored() > 0) {
    std::fprintf(stderr, "ldp watch: %lld malformed messages were ignored\n", static_cast<long long>(listener->ignored()));
  }
  return kDone;
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
  app.add_option("--status", config.status, "lcm:udpm://239.255.76.67:7667?ttl=0, led:name=LINE, console:; several allowed");
  app.add_option("-o,--output", config.output, "Folder to make");
  app.add_option("--mode", command->mode, "hold: while the button is held; toggle: press to begin, press to end")
      ->check(CLI::IsMember({"hold", "toggle"}))
      ->capture_default_str();
  app.add_option("--overlap", config.overlap, "Of neighbouring frames")->check(CLI::Range(0.3, 0.95))->capture_default_str();
  app.add_option("--max-frames", config.max_frames, "The sweep ends after so many")
      ->check(CLI::Range(3, 1000))
      ->capture_default_str();
  app.add_option("--max-seconds", config.max_seconds, "The sweep ends after so long")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--fov", config.fov_degrees, "Horizontal field of view, degrees; 0 = unknown")
      ->check(CLI::Range(0.0, 170.0))
      ->capture_default_str();
}

void add_watch(Program& program) {
  auto command = std::make_shared<WatchCommand>();
  CLI::App& app = add_command(program, "watch", "Show what a device tells over LCM, or send it a command",
                              [command](const Session& session) { return run_watch(*command, session); });
  app.add_option("--status", command->url, "LCM address, or a log as lcm:file://LOG?speed=0")->capture_default_str();
  app.add_option("--send", command->send, "press, release, cancel or retry");
  app.add_option("--count", command->count, "End after so many messages; 0 = never")->check(CLI::Range(0, 1000000000));
}

}  // namespace ldp
