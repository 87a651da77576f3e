// Cubic interpolation along Catmull and Rom's spline, in integers.
#pragma once

#include <array>
#include <cstdint>

namespace ldp {

// The denominator of catmull_rom's weights.
constexpr int64_t catmull_rom_whole(int64_t positions) { return 2 * positions * positions * positions; }

// Exact weights of four samples, in 1 / catmull_rom_whole(positions), at position / positions of the way from the
// second to the third; their sum is 1. At most 2^10 positions.
constexpr std::array<int64_t, 4> catmull_rom(int64_t position, int64_t positions) {
  const int64_t t = position, t2 = t * t, t3 = t2 * t, s = positions, s2 = s * s;
  return {-t3 + 2 * s * t2 - s2 * t, 3 * t3 - 5 * s * t2 + 2 * s2 * s, -3 * t3 + 4 * s * t2 + s2 * t, t3 - s * t2};
}

}  // namespace ldp
