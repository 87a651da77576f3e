// The last iteration on matches, with and without a prior of smooth motion. What walks by between two photos agrees
// with a step that nobody took; cameras of smoother motion, with nearly as many inliers, tell it from what stands.
#pragma once

#include <vector>

#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/refine/refine_tuning.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

size_t observations(const std::vector<Track>& tracks);

// Observations that are inliers of the cameras.
double inlier_observations(const MatchedSweep& sweep, const std::vector<Track>& tracks, Reconstruction r,
                           const Job& job);

// Tracks by the steps of the sequence that they are seen on both sides of: from each frame to the next.
std::vector<int> tracks_across_steps(const std::vector<Track>& tracks, int frames);

// Whether cameras lose half or more of the tracks that others have across a step.
bool breaks_connectivity(const std::vector<int>& across, const std::vector<int>& across_of_others);

// The iteration on all matches; the same is tried with smooth motion, which stays if it is smoother for the inliers
// that it loses and breaks no step.
void final_match_refinement(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                            IterativeRefinement& refinement, const Job& job, Reconstruction& result);

}  // namespace ldp::sfm
