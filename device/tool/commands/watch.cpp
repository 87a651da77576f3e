// ldp watch: what a device tells over LCM, or a recorded log of it.

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "core/geometry/degrees.h"
#include "device/backends/open.h"
#include "device/gallery/status_json.h"
#include "device/service/reasons.h"
#include "device/tool/commands.h"
#include "device/tool/number_within.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/status.h"
#include "drivers/interface/unique_fd.h"

namespace ldp {
namespace {

constexpr const char* kLcm = "lcm:udpm://239.255.76.67:7667?ttl=0";

struct WatchCommand {
  std::string url = kLcm, send;
  int count = 0;
};

using Json = nlohmann::ordered_json;

std::string line_from(const Status& status) {
  return "status    " + std::string(name_of(status.phase)) + ": " + status.text + " (" +
         frames_text(status.frames_stored) + " stored, " + std::to_string(status.sweeps_left) +
         (status.sweeps_left == 1 ? " sweep" : " sweeps") + " left)";
}
std::string line_from(const Progress& progress) {
  return "progress  " + progress.capture + " " + std::to_string(static_cast<int>(progress.fraction * 100)) + " % " +
         progress.stage;
}
std::string line_from(const Guidance& guidance) {
  char covered[32], speed[32] = "";
  std::snprintf(covered, sizeof covered, "%.0f degrees", guidance.covered_rad * kDegreesPerRadian);
  if (const double degrees_s = guidance.speed_rad_s * kDegreesPerRadian; degrees_s >= 0.5)  // none, or none yet
    std::snprintf(speed, sizeof speed, ", %.0f degrees/s", degrees_s);
  return "guidance  " + std::string(name_of(guidance.advice)) + ": " + covered + speed + ", " +
         frames_text(guidance.frames_chosen);
}
std::string line_from(const Result& result) {
  std::string line =
      "result    " + std::string(result.ok ? result.file : result.capture + " failed") + ": " + result.text;
  if (result.verdict != Judgement::none) line += "; " + std::string(name_of(result.verdict));
  for (const char c : result.reasons) line += c == '\n' ? std::string("; ") : std::string(1, c);
  return line;
}

void print(const HeardMessage& heard, bool as_json) {
  char utc[32];
  utc_text(heard.utc_ns, utc);
  if (as_json) {
    Json json = gallery::json_from(heard.message);
    json["utc"] = utc;
    json["monotonic_ns"] = heard.monotonic_ns;
    std::printf("%s\n", json_text(json).c_str());
  } else {
    const std::string line = std::visit([](const auto& message) { return line_from(message); }, heard.message);
    std::printf("%s  %s\n", utc, printable(line).c_str());  // it may be a stranger's datagram
  }
  std::fflush(stdout);
}

Command command_from(const std::string& word) {
  for (const Command command : kCommands) {
    if (word == name_of(command)) return command;
  }
  throw BadInput("--send " + word + ": is not press, release, stop, cancel or retry");
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
      if (++printed == command.count || std::ferror(stdout) != 0) return kDone;  // main tells of what is not written
    }
    going = !listener->ended() && wait_for(listener->fd(), end.get());
  }
  if (listener->ignored() > 0) {
    std::fprintf(stderr, "ldp watch: %lld malformed messages were ignored\n",
                 static_cast<long long>(listener->ignored()));
  }
  return kDone;
}

}  // namespace

void add_watch(Program& program) {
  auto command = std::make_shared<WatchCommand>();
  CLI::App& app = add_command(program, "watch", "Show what a device tells over LCM, or send it a command",
                              [command](const Session& session) { return run_watch(*command, session); });
  app.add_option("--status", command->url, "LCM address, or a log as lcm:file://LOG?speed=0")->capture_default_str();
  app.add_option("--send", command->send, "press, release, stop (ends the sweep), cancel or retry");
  app.add_option("--count", command->count, "End after so many messages; 0 = never")
      ->check(whole_within(0, 1000000000));
}

}  // namespace ldp
