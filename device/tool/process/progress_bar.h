// How far long work is: a bar on a terminal, lines for a parent process that asked for them, nothing on a pipe.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace ldp {

class ProgressBar {
 public:
  // progress_fd: where lines "FRACTION STAGE" go, -1 = nowhere.
  explicit ProgressBar(int progress_fd = -1);
  ~ProgressBar();  // wipes the bar
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::string_view stage, double fraction);
  // What a person should hear before the work ends: "so far: TEXT", a line on a terminal, and a stage to the parent.
  void remark(std::string_view text);

 private:
  void draw(std::string_view stage, double fraction);
  void tell_parent(std::string_view stage, double fraction);

  bool on_terminal_ = false, drawn_ = false;
  int progress_fd_ = -1;
  std::chrono::steady_clock::time_point last_;
  std::string last_stage_;
};

}  // namespace ldp
