// Structure from motion of a sweep, from verified matches to cameras: outlier rejection among pairs and rotation
// averaging (rotation_averaging.h), initialisation (initialisation.h), alternation of triangulation and bundle
// adjustment with free cameras (iterative_refinement.h), tracks by KLT (klt_tracking.h), and what kind of motion it
// was. Here frames that match no others, or that too few points hold, are left out with a reason
// (Reconstruction::left_out). Works in radii: the cameras' circle has radius about 1 and its centre at the origin.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Pairs that contradict the others leave the sweep. Throws Impossible when fewer than 3 frames hang together.
Reconstruction reconstruct(MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job);

}  // namespace ldp::sfm
