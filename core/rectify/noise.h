// How noisy a photograph is.
#pragma once

#include <cstdint>

#include "plane.h"

namespace ldp {

// Deviation of a photograph's noise from one pixel to the next, in levels of 255; `grey` in kSampleScale-ths of a
// level. The mixed second derivative, to which neither ramps nor edges along an axis contribute (Immerkaer, Fast Noise
// Variance Estimation, 1996), in the plainest cells of the picture; what is clipped does not count. Fine texture
// everywhere passes for noise. 0 for pictures without such a cell.
float noise_of(const Plane<uint16_t>& grey);

}  // namespace ldp
