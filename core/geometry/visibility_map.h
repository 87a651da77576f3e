// What hides voxels from a camera. Made by the stage `layers`, read by `sweep` and `colour`.
#pragma once

#include <cstdint>

#include "core/base/plane.h"

namespace ldp {

// What one upright camera sees first: inverse distance along `forward` (1 / (q . forward)) of the nearest surface, in
// units of `scale` per step, stored like the frame's columns (at(y, x)). A voxel is
// hidden when the surface is nearer than it by more than `tolerance` steps.
struct VisibilityMap {
  Plane<uint16_t> inverse_z;
  double scale = 0;
  int tolerance = 0;
};

}  // namespace ldp
