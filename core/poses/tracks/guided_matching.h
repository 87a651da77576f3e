// Guided matching, once cameras are known roughly: a feature of one frame is compared only with those of another that
// lie near its epipolar line, at any depth. What is left to confuse it with is little, so the same ratio
// test keeps more matches than among all features. For sweeps that show little, or are blurred.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/photos/left_out.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/match_graph.h"

namespace ldp::sfm {

// The sweep's pairs with what is found along epipolar lines added. Frames with a reason in `left_out` stay as they are.
std::vector<PairMatches> match_guided(const MatchedSweep& sweep, const Bundle& bundle,
                                      const std::vector<LeftOut>& left_out, const Job& job);

}  // namespace ldp::sfm
