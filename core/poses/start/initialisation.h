// Initialisation of bundle adjustment from rotation hypotheses, the focal length found by trying.
#pragma once

#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/start/rotation_averaging.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {

// The best of these hypotheses, each adjusted on a few tracks: on the sphere, then near it.
Bundle initialise_spherical(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                            const std::vector<RotationHypothesis>& hypotheses, const std::optional<FocalPrior>& prior,
                            const Job& job);

// The same for cameras that stay where they are, with the lens: every point at infinity, and not adjusted further.
Bundle initialise_pure_rotation(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                const std::vector<RotationHypothesis>& hypotheses,
                                const std::optional<FocalPrior>& prior, const Job& job);

}  // namespace ldp::sfm
