// Where bundle adjustment starts: from turns of the cameras, the focal length found by trying.
#pragma once

#include <optional>
#include <vector>

#include "bundle.h"
#include "job.h"
#include "matched_sweep.h"
#include "turns.h"

namespace ldp {

// The best of starts from these turns, each adjusted on a few tracks: on the sphere, then near it.
Bundle start(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
             const std::optional<FocalPrior>& prior, const Job& job);

// The same for cameras that stay where they are, with the lens: every point at infinity, and not adjusted further.
Bundle start_on_the_spot(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
                         const std::optional<FocalPrior>& prior, const Job& job);

// Every track becomes a point of the bundle, well or badly (at an arm's length or five where it cannot be
// triangulated).
void place_all(const std::vector<Track>& tracks, Bundle& bundle);

void add_point(const Track& track, const InversePoint& point, Bundle& bundle);

// Only what agrees: tracks lose observations farther off than the tolerance, or go altogether where half of them or
// more are: any two agree, and two of many are what is left of a thing that moves. Gives what is left, one per point of
// the bundle. `at_infinity`: all points are.
std::vector<Track> place_good(const std::vector<Track>& tracks, double tolerance_px, bool at_infinity, Bundle& bundle,
                              const Job& job);

// Longest tracks first, until every frame has its share.
std::vector<Track> longest_tracks(std::vector<Track> tracks, int frames, int per_frame);

}  // namespace ldp
