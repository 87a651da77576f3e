// From verified matches of a sweep to cameras: a start (start.h), bundle adjustment with free cameras in rounds of
// stricter tolerance, points followed through all frames (follow.h), and what kind of motion it was. Works in radii:
// the cameras' circle has radius about 1 and its centre at the origin.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "poses.h"
#include "start.h"

namespace ldp {

struct Reconstruction {
  Bundle bundle;                     // cameras by frame; those not posed keep the identity and have no observations
  std::vector<Track> tracks;         // of the bundle's points, inliers only
  std::vector<std::string> dropped;  // by frame: why it has no pose; empty when posed
  Motion motion = Motion::arc;
  bool closed = false;
};

// Pairs that contradict the others leave the sweep. Throws Impossible when fewer than 3 frames hang together.
Reconstruction reconstruct(MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job);

}  // namespace ldp
