// How the LED looks: what it shows, as on and off over equal steps of time.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/interface/status.h"

namespace ldp {

constexpr int64_t kLedStep_ns = 125'000'000;
constexpr int kLedSteps = 16;  // after which it begins anew

// Bit i, the lowest first: lit in step i.
//   capturing: on; building: half a second on and off; failed: an eighth on and off;
//   done: off, or two flashes every two seconds where the sweep should be taken again.
constexpr uint16_t led_pattern(Phase phase, Judgement judgement) {
  switch (phase) {
    case Phase::capturing:
      return 0xFFFF;
    case Phase::building:
      return 0x0F0F;
    case Phase::failed:
      return 0x5555;
    case Phase::done:
      return judgement == Judgement::sweep_again ? 0x0005 : 0;
    case Phase::idle:
      return 0;
  }
  return 0;
}

constexpr bool is_lit(uint16_t pattern, int64_t step) { return (pattern >> (step % kLedSteps) & 1) != 0; }

}  // namespace ldp
