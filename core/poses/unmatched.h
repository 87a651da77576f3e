// Features that matching left alone, as tracks of one observation each: where a neighbour in the picture is known to
// be, they are believed to be as far, so that following (follow.h) may find them in the frames around.
#pragma once

#include <utility>
#include <vector>

#include "bundle.h"
#include "matched_sweep.h"

namespace ldp {

struct Guesses {
  std::vector<Track> tracks;
  std::vector<InversePoint> points;  // of the tracks
};

// So many that each frame in which tracks (their points are the bundle's) are seen might come to see `wanted`.
Guesses unmatched(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& bundle, int wanted);

// Tracks from `first` on without those that show what an earlier one shows: these are emptied.
void empty_repeated(const MatchedSweep& sweep, size_t first, std::vector<Track>& tracks);

}  // namespace ldp
