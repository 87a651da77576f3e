// A pattern on the light's line. Woken when it is to look different, not in between: an idle camera lives on a battery.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "drivers/interface/clocks.h"
#include "drivers/interface/ticker.h"
#include "drivers/led_pattern.h"

namespace ldp {

class LedLight {
 public:
  explicit LedLight(std::function<void(bool lit)> set_line) : set_line_(std::move(set_line)) {}

  int fd() const { return ticker_.fd(); }

  void show(uint16_t pattern) {
    if (pattern == pattern_) return set_line_(is_lit(pattern_, step()));  // only use tells that a line has gone away
    pattern_ = pattern;
    begin_ns_ = monotonic_now_ns();
    ticker_.stop();
    follow_pattern();
  }

  // When fd() is readable.
  void wake() {
    if (ticker_.take_expirations() > 0) follow_pattern();
  }

 private:
  void follow_pattern() {
    const int64_t now = step();
    set_line_(is_lit(pattern_, now));
    if (const auto steps = steps_to_change(pattern_, now)) {
      ticker_.start_at(begin_ns_ + (now + *steps) * kLedStep_ns, 0);
    }
  }

  int64_t step() const { return (monotonic_now_ns() - begin_ns_) / kLedStep_ns; }

  std::function<void(bool)> set_line_;
  Ticker ticker_;
  uint16_t pattern_ = 0;
  int64_t begin_ns_ = 0;  // of the pattern
};

}  // namespace ldp
