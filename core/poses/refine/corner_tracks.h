// Corners of the pictures that no feature marks join what is followed: where three photos hardly share a feature, they
// share many of these.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp {

// Adds tracks of three photos or more, and their points, where a frame sees little between others that see it too. Of
// cameras that are nearly right already.
void gather_corners(const MatchedSweep& sweep, const Job& job, Reconstruction& r);

}  // namespace ldp
