// Matches by descriptor distance: mutual nearest neighbours among the feature points of two photographs that pass
// Lowe's ratio test against the second best. Exact integer arithmetic. What they look like is all that is compared
// here; geometry is checked by whoever knows the cameras.
#pragma once

#include <vector>

#include "core/poses/features/features.h"

namespace ldp::sfm {

struct Match {
  int a = 0, b = 0;  // indices of the points in the two photographs
  int distance = 0;  // squared, of the descriptors
  friend bool operator==(const Match&, const Match&) = default;
};

struct MatchOptions {
  double ratio = 0.82;   // of the distances to the best and the second best
  int max_features = 0;  // only the first so many points of each photograph; 0 = all
};

std::vector<Match> match_features(const Features& a, const Features& b, const MatchOptions& options);

}  // namespace ldp::sfm
