// The match graph: a sweep as matching leaves it, and which of its matches are inliers of cameras.
#pragma once

#include <string>
#include <vector>

#include "core/photos/left_out.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/track_tuning.h"
#include "core/poses/tracks/tracks.h"

namespace ldp::sfm {

// What is known of a sweep before any camera is.
struct MatchedSweep {
  std::vector<GreyPhoto> pictures;  // all of one size
  std::vector<Features> features;
  std::vector<PairMatches> pairs;  // verified
  int track_grid = 1;              // the longest tracks come evenly from so many by so many cells of each photo
  int unfit = 0;                   // photos that can be no part of it
  std::string first_unfit_name;    // of the first of them that shows what no other does
  LeftOut first_unfit;             // and why

  int frames() const { return static_cast<int>(features.size()); }
  // Tolerances are stated in pixels of a photo 800 pixels long; this is so many pixels of these photos.
  double pixels(double of_800) const;
};

// Those that do for a coarse start (tracks.h), by the sweep's grid.
std::vector<Track> longest_tracks(std::vector<Track> tracks, const MatchedSweep& sweep, int per_frame);

bool is_plausible(const InversePoint& point, double nearest = kMaxInverseDistance);

// A track as its cameras see it. `at_infinity`: of points there, for which a camera's place does not matter.
std::vector<Sighting> sightings(const Track& track, const Bundle& bundle, bool at_infinity = false);

// Which of a pair's matches agree with the cameras within the tolerance, on a point of plausible depth.
std::vector<bool> inlier_matches(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair,
                                 double tolerance_px, bool at_infinity = false, double nearest = kMaxInverseDistance);

// The share of inliers, 0 .. 1.
double inlier_ratio(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair, double tolerance_px,
                    bool at_infinity = false);

}  // namespace ldp::sfm
