// Geometric verification, which frames of a sweep see the same things: matches of neighbours in the sequence and of
// loop closures, each checked by a fundamental matrix of its own (no focal length needed yet).
#pragma once

#include <vector>

#include "core/poses/tracks/tracks.h"

namespace ldp {

struct PairOptions {
  int reach = 4;           // neighbours farther apart in the sequence are matched only if a quick look finds a loop
  int least_inliers = 16;  // fewer agreeing matches are chance
  int least_loop_inliers = 30;  // the same for frames far apart: there are many such pairs, and repeated things in them
  double least_share = 0.4;     // of the matches that must agree; what looks alike by chance agrees on little
  double tolerance = 0.003;     // distance from the epipolar line, share of the longer image side
  unsigned seed = 1;
};

// Matches of two frames that agree with one epipolar geometry; empty when too few do. Frames farther apart than `reach`
// are compared fully only if a quick look at their strongest features promises something.
std::vector<Match> match_pair(const Features& a, const Features& b, bool neighbours, const PairOptions& options);

}  // namespace ldp
