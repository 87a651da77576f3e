// Corners of a picture: places whose surroundings change in every direction, so that they can be found again exactly
// (Shi and Tomasi, Good features to track, CVPR 1994).
#pragma once

#include <vector>

#include "core/base/plane.h"

namespace ldp::sfm {

struct Corner {
  float strength = 0;  // smaller eigenvalue of the sum of gradients' outer products, (grey levels per pixel)^2
  int x = 0, y = 0;    // pixel
};

// Local maxima of strength, the strongest first, at least `margin` pixels from the border.
std::vector<Corner> find_corners(const GreyImage& picture, int margin);

}  // namespace ldp::sfm
