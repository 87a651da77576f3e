// Inpainting: continues the background over the holes of a view.
//
// A hole lies beside a near surface that has moved away from what it hid, so it is filled from the farther surfaces at
// its rim alone (pull_push.h), which does not flicker from one view of a path to the next.
#pragma once

#include "core/base/plane.h"

namespace ldp::view {

// Pixels with alpha below 255 are mixed with the background in that proportion. inverse_z: of every pixel, negative
// where there is nothing. Gives the share of pixels that were holes (alpha below 128).
double fill_background(const Plane<float>& inverse_z, RgbImage& colour, Plane<uint8_t>& alpha);

// The inverse z of every pixel; of one with alpha below 255 and nothing of its own that of the farthest surface among
// the nearest ones to its left, right, top and bottom, 0 where there is none.
Plane<float> background_behind_holes(const Plane<float>& inverse_z, const Plane<uint8_t>& alpha);

}  // namespace ldp::view
