// A sweep as reconstructed so far. In radii: the cameras' circle has radius about 1 and its centre at the origin.
#pragma once

#include <vector>

#include "core/geometry/camera_motion.h"
#include "core/photos/left_out.h"
#include "core/poses/tracks/bundle.h"

namespace ldp::sfm {

struct Reconstruction {
  Bundle bundle;                  // cameras by frame; those not posed keep the identity and have no observations
  std::vector<Track> tracks;      // of the bundle's points, inliers only
  std::vector<LeftOut> left_out;  // by frame: why it has no pose; none when posed
  Motion motion = Motion::arc;
  bool closed = false;
};

}  // namespace ldp::sfm
