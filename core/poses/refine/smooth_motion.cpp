#include "core/poses/refine/smooth_motion.h"

#include <numeric>
#include <utility>

#include "core/poses/refine/refine_tuning.h"
#include "core/poses/start/motion_model.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

std::vector<Track> inlier_tracks(const MatchedSweep& sweep, const std::vector<Track>& tracks, Reconstruction r,
                                 const Job& job) {
  return triangulate_inliers(tracks, sweep.pixels(kFineTolerance_px), false, r.bundle, job);
}

// Cameras put back on their sphere and held near it while inliers gather. Distortion stays: freed, it would take on
// what the sphere cannot explain, and half the focal length with barrel distortion passes for any.
void refine_smoothly(const MatchedSweep& sweep, const std::vector<Track>& tracks, IterativeRefinement refinement,
                     Reconstruction& r) {
  refinement.set_min_arc_sigma(0);
  refinement.fix_distortion();
  for (Pose& pose : r.bundle.cameras) pose.centre = pose.world_from_camera.col(2);
  const std::vector<Track> coarse = longest_tracks(tracks, sweep, kCoarseObservationsPerFrame);
  for (size_t i = 0; i < std::size(kSmoothArcSigmas); ++i)
    refinement.iterate(i + 1 < std::size(kSmoothArcSigmas) ? coarse : tracks, kMatchTolerances_px[i],
                       kSmoothArcSigmas[i], r);
}

// What walks by is some of what a step shows. Motion that is smoother for the loss of nearly all of it is wrong there.
bool smoother_is_better(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Reconstruction& smooth,
                        const Reconstruction& other, const Job& job) {
  const std::vector<Track> inliers = inlier_tracks(sweep, tracks, smooth, job),
                           inliers_of_other = inlier_tracks(sweep, tracks, other, job);
  const double gain =
      1 - motion_roughness(smooth.left_out, smooth.bundle) / motion_roughness(other.left_out, other.bundle);
  const double least = (1 - kSmoothnessTradeOff * gain) * static_cast<double>(observations(inliers_of_other));
  return static_cast<double>(observations(inliers)) >= least &&
         !breaks_connectivity(tracks_across_steps(inliers, sweep.frames()),
                              tracks_across_steps(inliers_of_other, sweep.frames()));
}

}  // namespace

size_t observations(const std::vector<Track>& tracks) {
  return std::accumulate(tracks.begin(), tracks.end(), size_t{0},
                         [](size_t sum, const Track& t) { return sum + t.size(); });
}

double inlier_observations(const MatchedSweep& sweep, const std::vector<Track>& tracks, Reconstruction r,
                           const Job& job) {
  return static_cast<double>(observations(inlier_tracks(sweep, tracks, std::move(r), job)));
}

std::vector<int> tracks_across_steps(const std::vector<Track>& tracks, int frames) {
  std::vector<int> across(static_cast<size_t>(frames), 0);
  for (const Track& track : tracks) {
    for (size_t i = 0; i + 1 < track.size(); ++i) {
      if (track[i + 1].frame == track[i].frame + 1) ++across[static_cast<size_t>(track[i].frame)];
    }
  }
  return across;
}

bool breaks_connectivity(const std::vector<int>& across, const std::vector<int>& across_of_others) {
  for (size_t i = 0; i < across.size(); ++i) {
    if (across_of_others[i] >= kMinTracksAcrossStep && across[i] <= kBrokenStepShare * across_of_others[i]) return true;
  }
  return false;
}

void final_match_refinement(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                            IterativeRefinement& refinement, const Job& job, Reconstruction& result) {
  const bool has_arc_prior = refinement.has_arc_prior();
  Reconstruction smooth = result;
  if (has_arc_prior) refinement.use_threads(job.threads / 2);
  const IterativeRefinement before = refinement;
  parallel_for(job, has_arc_prior ? 2 : 1, [&](int which) {
    if (which == 1) return refine_smoothly(sweep, tracks, before, smooth);
    refinement.iterate(tracks, kFineTolerance_px, kArcSigma, result);
    refinement.select_distortion_model(result);
  });
  refinement.use_threads(job.threads);
  if (!has_arc_prior) return;
  if (refinement.refines_distortion() && !before.refines_distortion())
    refine_smoothly(sweep, tracks, refinement, smooth = result);
  if (smoother_is_better(sweep, tracks, smooth, result, job)) result = std::move(smooth);
}

}  // namespace ldp::sfm
