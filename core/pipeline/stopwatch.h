// Seconds of stages, by name, in the order in which they first ended.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace ldp {

class Stopwatch {
 public:
  explicit Stopwatch(std::vector<std::pair<std::string, double>>& seconds) : seconds_(seconds) {}

  // Adds the time since its making, or since the last lap, to a stage.
  void lap(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    const double passed = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    for (auto& [name, sum] : seconds_)
      if (name == stage) {
        sum += passed;
        return;
      }
    seconds_.emplace_back(stage, passed);
  }

 private:
  std::vector<std::pair<std::string, double>>& seconds_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace ldp
