// The border of what is seen, without threads and islands.
#pragma once

#include "core/base/plane.h"

namespace ldp {

// Takes away what is narrower than 2 kThread_px + 1 pixels (a morphological opening), and then parts that hang together
// in fewer than kIsland of the picture's pixels; where that is all there is, nothing. What lies along the picture's
// edge goes on beyond it. present: 0 = nothing is seen there.
inline constexpr int kThread_px = 3;       // 1 .. 8
inline constexpr double kIsland = 0.0005;  // 0 .. 0.01
void trim_rags(Plane<uint8_t>& present);

// 1: nothing is seen there, nor on some way from there to the picture's edge.
Plane<uint8_t> beyond_border(const Plane<uint8_t>& present);

}  // namespace ldp
