// Outlier rejection by depth, of points that nothing around them is as far as: two photos agree on any depth along a
// line of sight, so a wrong match of something repeated that lies there is seen by its depth only, which no neighbour
// in the picture shares.
#pragma once

#include <vector>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/tracks/tracks.h"

namespace ldp::sfm {

// For each track (its point is bundle.points[i]) whether only two photos see it, and with `tolerance_px` more or less
// parallax between them than all but one of the nearest in the picture; or it lies so much beyond infinity. None
// where many seem so: then the cameras are not good enough to tell.
std::vector<bool> depth_outliers(const std::vector<Track>& tracks, const Bundle& bundle, double tolerance_px);

}  // namespace ldp::sfm
