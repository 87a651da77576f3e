// How much of what photos have in common a reconstruction explains, by where it lies in them and not by how many points
// it is: what walks by, or repeats itself, has many points in few places.
#pragma once

#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Of kCoverageGrid x kCoverageGrid cells of each posed photo, so many that hold a point of the reconstruction, and so
// many that hold a match of the sweep's pairs. Points come from tracks by KLT too, so the first may be more.
struct Coverage {
  int explained = 0, matched = 0;
  double share() const { return matched > 0 ? static_cast<double>(explained) / matched : 1; }
};

Coverage coverage(const MatchedSweep& sweep, const Reconstruction& r);

}  // namespace ldp::sfm
