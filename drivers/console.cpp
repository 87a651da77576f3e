// Status as lines of text on standard error: a terminal's, or journald's.
#include <cstdio>
#include <sstream>
#include <string>

#include "drivers/backends.h"

namespace ldp {
namespace {

constexpr double kDegrees = 57.29577951308232;

class ConsoleStatus final : public StatusChannel {
 public:
  void publish(const StatusMessage& message) override {
    std::visit([this](const auto& m) { say(m); }, message);
  }

 private:
  void say(const Status& status) {
    const std::string line = std::string(name_of(status.phase)) + ": " + status.text;
    if (line != last_status_) std::fprintf(stderr, "%s\n", line.c_str());  // repeats every second are for the network
    last_status_ = line;
    if (status.frames_stored != last_stored_ && status.frames_stored > 0) {
      std::fprintf(stderr, "stored: %d frames\n", status.frames_stored);
    }
    last_stored_ = status.frames_stored;
  }

  void say(const Progress& progress) {
    if (progress.stage == last_stage_) return;  // a line a stage; every step is for the network
    last_stage_ = progress.stage;
    std::fprintf(stderr, "building %s: %s\n", progress.capture.c_str(), progress.stage.c_str());
  }

  void say(const Guidance& guidance) {
    if (guidance.advice == last_advice_ && guidance.frames_chosen == last_frames_) return;
    last_advice_ = guidance.advice;
    last_frames_ = guidance.frames_chosen;
    std::fprintf(stderr, "sweep: %d frames, %.0f degrees, %s\n", guidance.frames_chosen,
                 guidance.covered_rad * kDegrees, name_of(guidance.advice));
  }

  void say(const Result& result) {
    std::fprintf(stderr, "%s: %s\n", result.ok ? result.file.c_str() : result.capture.c_str(), result.text.c_str());
    if (result.verdict != Judgement::none) {
      std::fprintf(stderr, "%s: new views of about %.0f dB\n", name_of(result.verdict), result.expected_view_psnr_db);
    }
    std::istringstream reasons(result.reasons);
    for (std::string reason; std::getline(reasons, reason);) std::fprintf(stderr, "  %s\n", reason.c_str());
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
