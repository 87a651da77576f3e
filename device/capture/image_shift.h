// How far the picture moved between two thumbnails: what the frame choice and the guidance go by.
#pragma once

#include "core/base/plane.h"

namespace ldp {

// The picture content moved by (dx, dy) pixels of the thumbnail from the first to the second image: a camera that turns
// to the right has dx < 0. `match` is the normalised cross-correlation of the overlap there, 1 = identical.
struct Shift {
  double dx_px = 0, dy_px = 0;
  double match = 0;
};

// Searches every shift of up to `reach` (share of the width, at most 0.75) sideways and a fifth of the height up and
// down, first on half-size images; parabolas give the fraction of a pixel. Brightness and contrast may differ.
// Images must have the same size. About 1 ms.
Shift estimate_shift(const GreyImage& first, const GreyImage& second, double reach = 0.6);

double mean_brightness(const GreyImage& image);  // 0 .. 1

}  // namespace ldp
