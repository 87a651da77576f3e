// How much of what photos have in common a reconstruction explains, by where it lies in them and not by how many points
// it is: what walks by, or repeats itself, has many points in few parts of the photos.
#pragma once

#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Of kCoverageGrid x kCoverageGrid parts of each posed photo, so many that hold a point of the reconstruction, and so
// many that hold a match of its pairs.
struct Coverage {
  int explained = 0, matched = 0;
  double share() const { return matched > 0 ? static_cast<double>(explained) / matched : 1; }
};

Coverage coverage(const MatchedSweep& sweep, const Reconstruction& r);

}  // namespace ldp::sfm
