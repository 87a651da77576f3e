// Status as lines of text on standard error: a terminal's, or journald's.
#include <cstdio>
#include <sstream>
#include <string>

#include "core/base/markup_text.h"
#include "core/geometry/degrees.h"
#include "drivers/backends.h"
#include "drivers/interface/standard_streams.h"

namespace ldp {
namespace {

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", value);
  return text;
}

void put(const std::string& line) { say(printable(line)); }

class ConsoleStatus final : public StatusChannel {
 public:
  void publish(const StatusMessage& message) override {
    std::visit([this](const auto& m) { say(m); }, message);
  }

 private:
  void say(const Status& status) {
    const std::string line = std::string(name_of(status.phase)) + ": " + status.text;
    if (line != last_status_) put(line);  // repeats every second are for the network
    last_status_ = line;
    if (status.frames_stored != last_stored_ && status.frames_stored > 0) {
      put("stored: " + std::to_string(status.frames_stored) + " frames");
    }
    last_stored_ = status.frames_stored;
  }

  void say(const Progress& progress) {
    if (progress.stage == last_stage_) return;  // a line a stage; every step is for the network
    last_stage_ = progress.stage;
    put("building " + progress.capture + ": " + progress.stage);
  }

  void say(const Guidance& guidance) {
    if (guidance.advice == last_advice_ && guidance.frames_chosen == last_frames_) return;
    last_advice_ = guidance.advice;
    last_frames_ = guidance.frames_chosen;
    put("sweep: " + std::to_string(guidance.frames_chosen) + " frames, " +
        rounded(guidance.covered_rad * kDegreesPerRadian) + " degrees, " + name_of(guidance.advice));
  }

  void say(const Result& result) {
    put((result.ok ? result.file : result.capture) + ": " + result.text);
    if (result.verdict != Judgement::none) {
      put(std::string(name_of(result.verdict)) + ": new views of about " + rounded(result.expected_view_psnr_db) +
          " dB");
    }
    std::istringstream reasons(result.reasons);
    for (std::string reason; std::getline(reasons, reason);) put("  " + reason);
    last_stage_.clear();
  }

  std::string last_status_, last_stage_;
  int last_frames_ = -1, last_stored_ = 0;
  Advice last_advice_ = Advice::keep_going;
};

}  // namespace

void check_console_status(const Url& url) { url.allow_only(""); }

std::unique_ptr<StatusChannel> open_console_status(const Url& url) {
  check_console_status(url);
  return std::make_unique<ConsoleStatus>();
}

}  // namespace ldp
