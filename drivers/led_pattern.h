// How the LED looks: what it shows, as on and off over equal steps of time.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/interface/status.h"

namespace ldp {

constexpr int64_t kLedStep_ns = 125'000'000;
constexpr int kLedSteps = 16;  // after which it begins anew

enum class LedSign : uint8_t { ready, sweep, too_fast, building, good, sweep_again, full, failed };
inline constexpr std::array kLedSigns = {LedSign::ready, LedSign::sweep,       LedSign::too_fast, LedSign::building,
                                         LedSign::good,  LedSign::sweep_again, LedSign::full,     LedSign::failed};

// What has been said last.
struct LedSources {
  Phase phase = Phase::idle;
  bool has_room = true;  // for another sweep
  Advice advice = Advice::keep_going;
  Judgement judgement = Judgement::none;
};

// A result is shown before that the card is full, which a refused sweep says too.
constexpr LedSign led_sign(const LedSources& said) {
  switch (said.phase) {
    case Phase::capturing:
      return said.advice == Advice::slower ? LedSign::too_fast : LedSign::sweep;
    case Phase::building:
      return LedSign::building;
    case Phase::done:
      return said.judgement == Judgement::sweep_again ? LedSign::sweep_again : LedSign::good;
    case Phase::failed:
      return said.has_room ? LedSign::failed : LedSign::full;
    case Phase::idle:
      return said.has_room ? LedSign::ready : LedSign::full;
  }
  return LedSign::failed;
}

// Bit i, the lowest first: lit in step i. The table in device/README.md says the same in words.
constexpr uint16_t led_pattern(LedSign sign) {
  switch (sign) {
    case LedSign::ready:
      return 0x0001;  // a flash every two seconds
    case LedSign::sweep:
      return 0xFFFF;
    case LedSign::too_fast:
      return 0x3333;  // a quarter of a second on and off
    case LedSign::building:
      return 0x0F0F;  // half a second
    case LedSign::good:
      return 0x00FF;  // a second
    case LedSign::sweep_again:
      return 0x0005;  // two flashes
    case LedSign::full:
      return 0x0015;  // three
    case LedSign::failed:
      return 0x5555;  // an eighth on and off
  }
  return 0;
}

constexpr bool is_lit(uint16_t pattern, int64_t step) { return (pattern >> (step % kLedSteps) & 1) != 0; }

// From this step to the next one that looks different; nothing where none does.
constexpr std::optional<int> steps_to_change(uint16_t pattern, int64_t step) {
  for (int steps = 1; steps < kLedSteps; ++steps) {
    if (is_lit(pattern, step + steps) != is_lit(pattern, step)) return steps;
  }
  return std::nullopt;
}

}  // namespace ldp
