#include "device/tool/process/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ldp {
namespace {

constexpr int kBarWidth = 30;
constexpr std::chrono::milliseconds kInterval{100};

void write_whole(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written <= 0) return;  // a parent that is gone, a terminal that is closed: progress is not worth failing for
    text.remove_prefix(static_cast<size_t>(written));
  }
}

}  // namespace

ProgressBar::ProgressBar(int progress_fd) : on_terminal_(::isatty(STDERR_FILENO) == 1), progress_fd_(progress_fd) {}

ProgressBar::~ProgressBar() {
  if (drawn_) write_whole(STDERR_FILENO, "\r\x1b[K");
}

void ProgressBar::show(std::string_view stage, double fraction) {
  if (!on_terminal_ && progress_fd_ < 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < kInterval && stage == last_stage_ && fraction < 1) return;
  last_ = now;
  last_stage_ = stage;
  const double share = std::clamp(fraction, 0.0, 1.0);
  if (on_terminal_) draw(stage, share);
  if (progress_fd_ >= 0) tell_parent(stage, share);
}

void ProgressBar::remark(std::string_view text) {
  if (on_terminal_) write_whole(STDERR_FILENO, "\r\x1b[Kso far: " + std::string(text) + "\n");
  if (progress_fd_ >= 0) tell_parent("so far: " + std::string(text), 1);
}

void ProgressBar::draw(std::string_view stage, double fraction) {
  const int filled = static_cast<int>(std::lround(fraction * kBarWidth));
  std::string line = "\r\x1b[K[";
  line +=
      std::string(static_cast<size_t>(filled), '#') + std::string(static_cast<size_t>(kBarWidth - filled), ' ') + "] ";
  char percent[16];
  std::snprintf(percent, sizeof percent, "%3.0f %% ", 100 * fraction);
  line += percent;
  line += stage;
  write_whole(STDERR_FILENO, line);
  drawn_ = true;
}

void ProgressBar::tell_parent(std::string_view stage, double fraction) {
  char number[32];
  std::snprintf(number, sizeof number, "%.4f ", fraction);
  write_whole(progress_fd_, number + std::string(stage) + "\n");
}

}  // namespace ldp
