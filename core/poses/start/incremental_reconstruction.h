// A start for motion that is not an arm's (straight paths, dollies, looking inward), and for arcs whose parts spherical
// motion joined wrongly. Two frames by an essential matrix, then one frame after the other by the points that it
// already shares (incremental structure from motion).
//
// The cameras' mean is the origin and their root mean square distance from it 1, since such a path has no radius.
#pragma once

#include <optional>
#include <vector>

#include "core/poses/start/initialisation.h"

namespace ldp::sfm {

struct IncrementalResult {
  Bundle bundle;
  std::vector<bool> posed;  // by frame
};

// The best over several focal lengths (around the prior's if there is one), `likely` among them; none when no two
// frames make a beginning.
std::optional<IncrementalResult> reconstruct_incrementally(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                                           const std::optional<FocalPrior>& prior,
                                                           double likely_focal_px, const Job& job);

}  // namespace ldp::sfm
