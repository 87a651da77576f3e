// A sweep as matching leaves it, and which of its matches agree with cameras.
#pragma once

#include <string>
#include <vector>

#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/tracks.h"

namespace ldp {

// What is known of a sweep before any camera is.
struct MatchedSweep {
  std::vector<GreyPhoto> pictures;  // all of one size
  std::vector<Features> features;
  std::vector<PairMatches> pairs;  // verified
  int left_out = 0;                // photos that can be no part of the sweep
  std::string first_left_out;      // its name and why; empty = none

  int frames() const { return static_cast<int>(features.size()); }
  // Tolerances are stated in pixels of a photo 800 pixels long; this is so many pixels of these photos.
  double pixels(double of_800) const;
};

constexpr double kNearest = 5, kBeyond = -0.1;  // inverse distances of points that are believed

bool believable(const InversePoint& point, double nearest = kNearest);

// A track as its cameras see it. `at_infinity`: of points there, for which a camera's place does not matter.
std::vector<Sighting> sightings(const Track& track, const Bundle& bundle, bool at_infinity = false);

// Which of a pair's matches agree with the cameras within the tolerance, on a point no nearer than believed.
std::vector<bool> agreeing_matches(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair,
                                   double tolerance_px, bool at_infinity = false, double nearest = kNearest);

// How many of them, 0 .. 1.
double agreeing_share(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair, double tolerance_px,
                      bool at_infinity = false);

}  // namespace ldp
