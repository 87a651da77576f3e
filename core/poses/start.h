// Where bundle adjustment starts: focal length found by trying, rotations of all pairs under spherical motion,
// averaged.
#pragma once

#include <optional>
#include <vector>

#include "bundle.h"
#include "job.h"
#include "points.h"

namespace ldp {

// What is known of a sweep before any camera is.
struct MatchedSweep {
  std::vector<GreyPhoto> pictures;  // all of one size
  std::vector<Features> features;
  std::vector<PairMatches> pairs;  // verified

  int frames() const { return static_cast<int>(features.size()); }
  // Tolerances are stated in pixels of a photo 800 pixels long; this is so many pixels of these photos.
  double pixels(double of_800) const;
};

// Starts from several focal lengths (around the prior's, or over all that cameras have), best first; each adjusted with
// free centres on a few tracks. Gives at least one.
std::vector<Bundle> starts(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                           const std::optional<FocalPrior>& prior, const Job& job);

// Every track becomes a point of the bundle, well or badly (at an arm's length or five where it cannot be
// triangulated).
void place_all(const std::vector<Track>& tracks, Bundle& bundle);

// Only what agrees: tracks lose observations farther off than the tolerance, or go altogether. Gives what is left, one
// per point of the bundle. `at_infinity`: all points are.
std::vector<Track> place_good(const std::vector<Track>& tracks, double tolerance_px, bool at_infinity, Bundle& bundle,
                              const Job& job);

// How many of a pair's matches agree with the cameras within the tolerance.
double agreeing_share(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair, double tolerance_px,
                      bool at_infinity = false);

// Longest tracks first, until every frame has its share.
std::vector<Track> longest_tracks(std::vector<Track> tracks, int frames, int per_frame);

}  // namespace ldp
