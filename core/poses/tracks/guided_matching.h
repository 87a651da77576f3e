// A second look at features once cameras are known roughly: a feature of one frame is compared only with those of
// another that lie along its line of sight, at any depth. What is left to confuse it with is little, so the same ratio
// test keeps two to three times as many matches as among all features. For sweeps that show little, or are blurred.
#pragma once

#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/match_graph.h"

namespace ldp {

// The sweep's pairs with what is found along lines of sight added. Frames with a reason in `dropped` stay as they are.
std::vector<PairMatches> match_guided(const MatchedSweep& sweep, const Bundle& bundle,
                                      const std::vector<std::string>& dropped, const Job& job);

}  // namespace ldp
