// Resection of frames that lost the others: few of their matches agree with the cameras, although they have enough. A
// circle whose focal length is not yet right lacks its loop closure and breaks at one frame, which then drifts.
#pragma once

#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Puts them on the sphere where the matches with a neighbour want them by the focal length found since, if more of
// their matches agree then. Whether there were any.
bool resect_lost_frames(const MatchedSweep& sweep, Reconstruction& r);

}  // namespace ldp::sfm
