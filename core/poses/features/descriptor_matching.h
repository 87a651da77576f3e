// Descriptor matching, which feature points of two photographs look alike: nearest neighbours that are clearly better
// than the second best (Lowe's ratio test) and mutual. Exact integer arithmetic. What they look like is all that is
// compared here; geometry is checked by whoever knows the cameras.
#pragma once

#include <vector>

#include "core/poses/features/features.h"

namespace ldp {

struct Match {
  int a = 0, b = 0;  // indices of the points in the two photographs
  int distance = 0;  // squared, of the descriptors
  friend bool operator==(const Match&, const Match&) = default;
};

struct MatchOptions {
  double ratio = 0.82;  // of the distances to the best and the second best
  int most = 0;         // only the first so many points of each photograph; 0 = all
};

std::vector<Match> match_features(const Features& a, const Features& b, const MatchOptions& options);

}  // namespace ldp
