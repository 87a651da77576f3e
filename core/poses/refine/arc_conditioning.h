// Conditioning of a sweep's swept angle: where it is poor, a sweep is worth more time than others are.
#pragma once

#include <vector>

#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

// Per frame, the tracks that are seen before, in and after it.
std::vector<int> tracks_through_frame(const Reconstruction& r);

// How two steps next to each other compare is told by what is seen before, in and after the photo between them: by n
// such points to about a step's share of 1 / sqrt(n). These errors add up along an open arc, as roots of squares; where
// that comes to more than a few degrees times what one point leaves open, the arc is ill-conditioned. Ends that meet
// hold a closed one, and what is straight sweeps no angle. Of motion already described.
bool is_ill_conditioned(const Reconstruction& r);

}  // namespace ldp::sfm
