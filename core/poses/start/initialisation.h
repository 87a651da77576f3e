// Initialisation, where bundle adjustment starts: from turns of the cameras, the focal length found by trying.
#pragma once

#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/start/rotation_averaging.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/point_placement.h"

namespace ldp {

// The best of starts from these turns, each adjusted on a few tracks: on the sphere, then near it.
Bundle start(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
             const std::optional<FocalPrior>& prior, const Job& job);

// The same for cameras that stay where they are, with the lens: every point at infinity, and not adjusted further.
Bundle start_on_the_spot(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
                         const std::optional<FocalPrior>& prior, const Job& job);

}  // namespace ldp
