// Which frames of a sweep see the same things: matches of neighbours in the sequence and of loop closures, each checked
// by a fundamental matrix of its own (no focal length needed yet).
#pragma once

#include <vector>

#include "job.h"
#include "points.h"

namespace ldp {

struct PairOptions {
  int reach = 4;             // neighbours farther apart in the sequence are matched only if a quick look finds a loop
  int least_inliers = 16;    // fewer agreeing matches are chance
  double tolerance = 0.003;  // distance from the epipolar line, share of the longer image side
  unsigned seed = 1;
};

// Pairs (a < b) with enough agreeing matches, in order of (a, b).
std::vector<PairMatches> match_sweep(const std::vector<Features>& features, const PairOptions& options, const Job& job);

// Matches of one pair that agree with one epipolar geometry; empty when too few do.
std::vector<Match> verified_matches(const Features& a, const Features& b, const PairOptions& options);

}  // namespace ldp
