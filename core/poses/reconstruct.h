// From verified matches of a sweep to cameras: focal length found by trying, rotations under spherical motion, then
// bundle adjustment with free cameras. Works in radii: the cameras' circle has radius about 1 and its centre at the
// origin.
#pragma once

#include <optional>
#include <vector>

#include "bundle.h"
#include "job.h"
#include "points.h"

namespace ldp {

struct Sweep {
  std::vector<Features> features;  // all of one size
  std::vector<PairMatches> pairs;  // verified
};

struct ReconstructOptions {
  std::optional<FocalPrior> focal;  // pixels
};

struct Reconstruction {
  Bundle bundle;              // cameras by frame; those not posed keep the identity and have no observations
  std::vector<bool> posed;    // by frame
  std::vector<Track> tracks;  // of the bundle's points, inliers only
};

// Throws Impossible when fewer than 3 frames hang together.
Reconstruction reconstruct(const Sweep& sweep, const ReconstructOptions& options, const Job& job);

}  // namespace ldp
