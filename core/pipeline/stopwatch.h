// Seconds of stages, by name, in the order in which they first ended: of wall time, and of the processors' over all
// threads of the process.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "core/base/processor_time.h"

namespace ldp {

using StageSeconds = std::vector<std::pair<std::string, double>>;

class Stopwatch {
 public:
  Stopwatch(StageSeconds& wall, StageSeconds& processor) : wall_(wall), processor_(processor) {}

  // Adds the time since its making, or since the last lap, to a stage.
  void lap(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    const double worked = processor_seconds();
    add(wall_, stage, std::chrono::duration<double>(now - last_).count());
    add(processor_, stage, worked - worked_);
    last_ = now;
    worked_ = worked;
  }

 private:
  static void add(StageSeconds& seconds, const std::string& stage, double passed) {
    for (auto& [name, sum] : seconds)
      if (name == stage) {
        sum += passed;
        return;
      }
    seconds.emplace_back(stage, passed);
  }

  StageSeconds &wall_, &processor_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  double worked_ = processor_seconds();
};

}  // namespace ldp
