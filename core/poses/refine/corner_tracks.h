// Tracks of corners that no feature marks: where three photos hardly share a feature, they
// share many of these.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Adds tracks of three photos or more, and their points, where a frame sees little between others that see it too. Of
// cameras that are nearly right already.
void add_corner_tracks(const MatchedSweep& sweep, const Job& job, Reconstruction& r);

}  // namespace ldp::sfm
