// The last round on matches, and what of them cameras explain. What walks by between two photos agrees with a step that
// nobody took; cameras of a steadier hand, that explain nearly as much, tell it from what stands.
#pragma once

#include <vector>

#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp {

constexpr int kThin = 250;  // observations per frame that do for the first rounds, the longest tracks first

size_t observations(const std::vector<Track>& tracks);

// Observations that agree with the cameras.
double explained(const MatchedSweep& sweep, const std::vector<Track>& tracks, Reconstruction r, const Job& job);

// Tracks by the steps of the sequence that they are seen on both sides of: from each frame to the next.
std::vector<int> across_steps(const std::vector<Track>& tracks, int frames);

// Whether cameras lose half or more of what others explain across a step.
bool tears(const std::vector<int>& across, const std::vector<int>& across_of_others);

// The round on all matches; the same is tried with a steadier hand, and the hand that is steadier, for what it
// explains, stays if it tears no step.
void last_matched_round(const MatchedSweep& sweep, const std::vector<Track>& tracks, Rounds& rounds, const Job& job,
                        Reconstruction& result);

}  // namespace ldp
