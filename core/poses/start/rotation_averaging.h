// Rotation averaging of a sweep for every focal length that its cameras may have: rotations of all pairs under
// spherical motion, averaged (spherical_motion.h). And outlier rejection of matches that contradict that, because a
// sweep shows things twice that look the same (windows, chairs, a pattern on a wall): photos are taken one after the
// other, so neighbours are trusted first.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/start/spherical_motion.h"
#include "core/poses/start/start_tuning.h"
#include "core/poses/tracks/match_graph.h"

namespace ldp::sfm {

// Views of the longer side, radians: beyond these hardly any camera's; and the view that these photos would have.
double view_of_longer_side(const MatchedSweep& sweep, double focal_px);

// What any camera may have.
FocalPrior generic_focal_prior(const MatchedSweep& sweep);

// The cameras' rotations, if their focal length is this.
struct RotationHypothesis {
  double focal_px = 0;
  std::vector<Eigen::Matrix3d> world_from_camera;
  std::vector<std::vector<uint8_t>> votes;  // by pair of the sweep and match: how surely it shows that too
};

enum class TwoViewMotion { spherical, rotation };  // what relative rotation is estimated under

// Of a pair's cameras, by some of its matches.
RelativeRotation relative_rotation(const MatchedSweep& sweep, const PairMatches& pair, double focal_px,
                                   TwoViewMotion motion);

// How each frame's matches with the next want the two turned, under spherical motion. A step whose matches contradict
// each other has none.
std::vector<StepPrior> step_priors(const MatchedSweep& sweep, double focal_px);

// For several focal lengths, around the prior's or over all that cameras have.
std::vector<RotationHypothesis> rotation_hypotheses(const MatchedSweep& sweep, const std::optional<FocalPrior>& prior,
                                                    TwoViewMotion motion, const Job& job);

// The sweep's pairs without matches that contradict the rotations whatever the focal length: of things that look the
// same and are not.
std::vector<PairMatches> reject_inconsistent_matches(std::vector<PairMatches> pairs,
                                                     const std::vector<RotationHypothesis>& hypotheses);

}  // namespace ldp::sfm
