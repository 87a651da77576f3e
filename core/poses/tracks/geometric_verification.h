// Two-view geometry: matches of neighbours in the sequence and of loop closures, each pair verified by a fundamental
// matrix of its own (no focal length needed yet) with outlier rejection by RANSAC.
#pragma once

#include <vector>

#include "core/poses/tracks/tracks.h"

namespace ldp::sfm {

struct TwoViewOptions {
  int sequential_window = 4;  // frames; farther apart in the sequence, only candidates for a loop closure are matched
  int min_inliers = 16;       // fewer agreeing matches are chance
  int min_loop_closure_inliers =
      30;  // the same for frames far apart: there are many such pairs, and repeated things in them
  double min_inlier_ratio = 0.4;      // of the matches that must agree; what looks alike by chance agrees on little
  double max_epipolar_error = 0.003;  // distance from the epipolar line, share of the longer image side
  unsigned seed = 1;
};

// Matches of two frames that agree with one epipolar geometry; empty when too few do. Frames farther apart than the
// window are compared fully only if enough of their strongest features match.
std::vector<Match> match_and_verify(const Features& a, const Features& b, bool neighbours,
                                    const TwoViewOptions& options);

}  // namespace ldp::sfm
