// From verified matches of a sweep to cameras: a start (initialisation.h), bundle adjustment with free cameras in
// rounds of stricter tolerance, points followed through all frames (klt_tracking.h), and what kind of motion it was.
// Here frames that match no others, or that too few points hold, are left out with a reason (Reconstruction::dropped).
// Works in radii: the cameras' circle has radius about 1 and its centre at the origin.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp {

// Pairs that contradict the others leave the sweep. Throws Impossible when fewer than 3 frames hang together.
Reconstruction reconstruct(MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job);

}  // namespace ldp
