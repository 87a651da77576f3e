// Triangulation of all of a bundle's tracks, with outlier rejection (of one point: triangulation.h).
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/poses/tracks/bundle.h"

namespace ldp::sfm {

// Every track becomes a point of the bundle, well or badly (at an arm's length or five where it cannot be
// triangulated).
void triangulate_tracks(const std::vector<Track>& tracks, Bundle& bundle);

// Only what agrees: tracks lose observations farther off than the tolerance, or go altogether where half of them or
// more are: any two agree, and two of many are what is left of a thing that moves. Gives what is left, one per point of
// the bundle. `at_infinity`: all points are.
std::vector<Track> triangulate_inliers(const std::vector<Track>& tracks, double tolerance_px, bool at_infinity,
                                       Bundle& bundle, const Job& job);

}  // namespace ldp::sfm
