// What is seen first at each place of the panorama, resampled to equal angles, and which part of the sphere it shows.
#pragma once

#include "core/base/plane.h"
#include "core/panorama/panorama.h"

namespace ldp {

struct FlatPanorama {
  RgbImage image;
  int full_width = 0, full_height = 0;  // of the whole sphere at this resolution
  int left = 0, top = 0;                // of the image in it
  // Of what is seen from a place (around.h): 1 / distance from the eye, 0 = at infinity. Empty of a flattened one.
  Plane<float> inverse_distance{};
};

// Without the threads and islands along its border (rags.h). Holes are filled from what lies farthest beside them, what
// lies beyond the border from all around.
FlatPanorama flatten(const LayeredPanorama& panorama);

}  // namespace ldp
