// How the cameras of a sweep turn, for every focal length that they may have: rotations of all pairs under spherical
// motion, averaged (spherical_motion.h). And which matches contradict that, because a sweep shows things twice that
// look the same (windows, chairs, a pattern on a wall): photos are taken one after the other, so neighbours are trusted
// first.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/start/spherical_motion.h"
#include "core/poses/tracks/match_graph.h"

namespace ldp {

constexpr double kOffTheSphere = 4;  // hands leave the sphere: jitter shows as so many pixels of 800

// Views of the longer side, radians: beyond these hardly any camera's; and the view that these photos would have.
constexpr double kTooWide = 125 * std::numbers::pi / 180, kTooNarrow = 8 * std::numbers::pi / 180;
double view_of_longer_side(const MatchedSweep& sweep, double focal_px);

// How the cameras turn, if their focal length is this.
struct Turns {
  double focal_px = 0;
  std::vector<Eigen::Matrix3d> world_from_camera;
  std::vector<std::vector<uint8_t>> votes;  // by pair of the sweep and match: how surely it shows that too
};

enum class Turning { on_the_sphere, on_the_spot };  // which motion of two frames tells how they turned

// How a pair's cameras turn by some of its matches.
RelativeRotation turn_between(const MatchedSweep& sweep, const PairMatches& pair, double focal_px, Turning turning);

// For several focal lengths, around the prior's or over all that cameras have.
std::vector<Turns> turns(const MatchedSweep& sweep, const std::optional<FocalPrior>& prior, Turning turning,
                         const Job& job);

// The sweep's pairs but those that turn otherwise than the rest whatever the focal length: things that look the same
// and are not.
std::vector<PairMatches> without_contradictions(std::vector<PairMatches> pairs, const std::vector<Turns>& turns);

}  // namespace ldp
