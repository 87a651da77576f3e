// What a view looks like without a layered panorama: the nearest photo, warped as if all lay at one depth.
//
// Takes the photos' cameras and one camera to stand in for; the depth is the one that comes closest to the true picture
// (so the baseline knows more than a build does). Gives colour, and alpha 0 where the nearest photo does not reach.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"

namespace ldp {

struct BaselineView {
  RgbImage colour;
  Plane<uint8_t> alpha;
  double depth = 0;  // z-depth of the plane taken; infinity = the photo was only turned
};

// The camera most alike: distance of centres against nearest_depth, plus the angle between the viewing directions.
int nearest_camera(const std::vector<Camera>& cameras, const Camera& target, double nearest_depth);

// Tries planes evenly spread in inverse depth, from infinity to nearest_depth.
BaselineView baseline_view(const RgbImage& photo, const Camera& camera, const Camera& target, const RgbImage& truth,
                           double nearest_depth);

}  // namespace ldp
