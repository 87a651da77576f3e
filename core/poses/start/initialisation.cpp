#include "core/poses/start/initialisation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/poses/start/start_tuning.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

struct Candidate {
  Bundle bundle;
  double cost = std::numeric_limits<double>::infinity();
  size_t inliers = 0, in_front = 0;  // observations
};

void adjust_candidate(Candidate& start, const BundleAdjustmentOptions& options, const Job& job) {
  const BundleAdjustmentSummary summary = adjust_bundle(start.bundle, options, job);
  start.cost = summary.usable && std::isfinite(summary.cost) ? summary.cost : std::numeric_limits<double>::infinity();
}

void sort_by_cost(std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
}

// The best few, different ones.
std::vector<Candidate> best_of(std::vector<Candidate> candidates, size_t most) {
  sort_by_cost(candidates);
  std::vector<Candidate> chosen;
  for (Candidate& candidate : candidates) {
    const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
      return std::abs(std::log(candidate.bundle.lens.focal_px / other.bundle.lens.focal_px)) < kSameLogFocal;
    });
    if (!known && chosen.size() < most) chosen.push_back(std::move(candidate));
  }
  return chosen;
}

// Counts observations that agree, and those among them of points that do not lie beyond infinity: of a world inside out
// hardly any.
void count_inliers(const MatchedSweep& sweep, const std::vector<Track>& tracks, Candidate& start, const Job& job) {
  Bundle bundle = start.bundle;
  triangulate_inliers(tracks, sweep.pixels(kStartTolerance_px), false, bundle, job);
  start.inliers = bundle.observations.size();
  start.in_front = static_cast<size_t>(
      std::count_if(bundle.observations.begin(), bundle.observations.end(), [&](const BundleObservation& o) {
        return bundle.points[static_cast<size_t>(o.point)].inverse_distance > kBehindInfinity;
      }));
}

// Without those that explain little with points in front of the cameras. Cost does not ask for that: where little
// parallax shows, motion the other way round with the world inside out may cost less than the truth.
std::vector<Candidate> passing_cheirality(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                          std::vector<Candidate> candidates, const Job& job) {
  size_t most = 0;
  for (Candidate& candidate : candidates) {
    count_inliers(sweep, tracks, candidate, job);
    most = std::max(most, candidate.inliers);
  }
  std::erase_if(candidates, [&](const Candidate& candidate) {
    return static_cast<double>(candidate.inliers) < kMinFrontShare * static_cast<double>(most);
  });
  return candidates;
}

// A track's observations, apart where many frames lie between: what a full turn sees again at its end. One whole where
// that leaves no two together.
std::vector<Track> split_at_gaps(const Track& track) {
  std::vector<Track> parts;
  for (size_t i = 0; i < track.size(); ++i) {
    if (i == 0 || track[i].frame - track[i - 1].frame > kMaxTrackGap) parts.emplace_back();
    parts.back().push_back(track[i]);
  }
  std::erase_if(parts, [](const Track& part) { return part.size() < 2; });
  return parts.empty() ? std::vector<Track>{track} : parts;
}

// Whether cameras explain a track, roughly. Each end of a full turn by itself, since hypotheses drift.
bool explains(const MatchedSweep& sweep, const Track& track, Bundle& cameras, const Job& job) {
  const std::vector<Track> parts = split_at_gaps(track);
  return std::all_of(parts.begin(), parts.end(), [&](const Track& part) {
    return !triangulate_inliers({part}, sweep.pixels(kStaticTolerance_px), false, cameras, job).empty();
  });
}

// The tracks that one of the hypotheses at least explains. The longest are often of what keeps pace with the camera,
// which none explains; adjusted to, they lead all hypotheses astray.
std::vector<Track> static_tracks(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                 const std::vector<RotationHypothesis>& hypotheses, const Job& job) {
  std::vector<std::vector<bool>> explained(hypotheses.size());
  Job alone = job;  // of each hypothesis
  alone.threads = 1;
  parallel_for(job, static_cast<int>(hypotheses.size()), [&](int i) {
    const RotationHypothesis& one = hypotheses[static_cast<size_t>(i)];
    Bundle cameras;
    cameras.lens.focal_px = one.focal_px;
    for (const Eigen::Matrix3d& r : one.world_from_camera) cameras.cameras.push_back({r, r.col(2)});
    for (const Track& track : tracks)
      explained[static_cast<size_t>(i)].push_back(explains(sweep, track, cameras, alone));
  });
  std::vector<Track> still;
  for (size_t t = 0; t < tracks.size(); ++t) {
    const auto by_one = [&](const std::vector<bool>& by) { return by[t]; };
    if (std::any_of(explained.begin(), explained.end(), by_one)) still.push_back(tracks[t]);
  }
  return still;
}

BundleAdjustmentOptions coarse_options(const MatchedSweep& sweep, const std::optional<FocalPrior>& prior) {
  BundleAdjustmentOptions options;
  options.focal_prior = prior.value_or(generic_focal_prior(sweep));
  options.loss_px = sweep.pixels(kSphereTolerance_px);
  options.max_iterations = 30;
  return options;
}

// One start from each of the hypotheses, finished by `finish` on one thread.
template <typename Finish>
std::vector<Candidate> candidates_from(const std::vector<RotationHypothesis>& hypotheses, const Job& job,
                                       const Finish& finish) {
  std::vector<Candidate> candidates(hypotheses.size());
  Job alone = job;
  alone.threads = 1;
  parallel_for(job, static_cast<int>(hypotheses.size()), [&](int i) {
    const RotationHypothesis& one = hypotheses[static_cast<size_t>(i)];
    Candidate& start = candidates[static_cast<size_t>(i)];
    start.bundle.lens.focal_px = one.focal_px;
    for (const Eigen::Matrix3d& r : one.world_from_camera) start.bundle.cameras.push_back({r, r.col(2)});
    finish(start, alone);
  });
  return candidates;
}

// The best of all hypotheses: on the sphere first, the best few of them then near it.
Candidate best_candidate(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                         const std::vector<RotationHypothesis>& hypotheses, BundleAdjustmentOptions options,
                         const Job& job) {
  Job alone = job;  // of each candidate
  alone.threads = 1;
  const auto adjust_with_steps = [&sweep](Candidate& start, BundleAdjustmentOptions with, const Job& own) {
    with.step_priors = step_priors(sweep, start.bundle.lens.focal_px);
    adjust_candidate(start, with, own);
  };
  options.model = MotionModel::spherical;
  std::vector<Candidate> candidates = candidates_from(hypotheses, job, [&](Candidate& start, const Job& own) {
    triangulate_tracks(tracks, start.bundle);
    adjust_with_steps(start, options, own);
  });
  candidates = best_of(passing_cheirality(sweep, tracks, std::move(candidates), job), kFreedStarts);
  options.model = MotionModel::free;
  parallel_for(job, static_cast<int>(candidates.size()),
               [&](int i) { adjust_with_steps(candidates[static_cast<size_t>(i)], options, alone); });
  return std::move(best_of(passing_cheirality(sweep, tracks, std::move(candidates), job), 1).front());
}

}  // namespace

Bundle initialise_spherical(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                            const std::vector<RotationHypothesis>& hypotheses, const std::optional<FocalPrior>& prior,
                            const Job& job) {
  const std::vector<Track> coarse =
      longest_tracks(static_tracks(sweep, longest_tracks(tracks, sweep, kStaticCandidates), hypotheses, job), sweep,
                     kStartObservationsPerFrame);
  BundleAdjustmentOptions options = coarse_options(sweep, prior);
  options.arc_sigma = kStartArcSigma;
  Candidate best = best_candidate(sweep, coarse, hypotheses, options, job);
  const size_t all = best.bundle.observations.size();
  if (static_cast<double>(best.in_front) > kMinFrontShare * static_cast<double>(all)) return std::move(best.bundle);
  options.enforce_cheirality = true;
  Candidate other = best_candidate(sweep, coarse, hypotheses, options, job);
  return std::move(other.in_front > best.in_front ? other.bundle : best.bundle);
}

Bundle initialise_pure_rotation(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                const std::vector<RotationHypothesis>& hypotheses,
                                const std::optional<FocalPrior>& prior, const Job& job) {
  const std::vector<Track> coarse = longest_tracks(tracks, sweep, kStartObservationsPerFrame);
  BundleAdjustmentOptions options = coarse_options(sweep, prior);
  options.model = MotionModel::rotation;
  options.refine_distortion = true;
  Job alone = job;  // of each candidate
  alone.threads = 1;
  std::vector<Candidate> candidates = candidates_from(hypotheses, job, [&](Candidate& start, const Job& own) {
    for (Pose& pose : start.bundle.cameras) pose.centre.setZero();
    triangulate_tracks(coarse, start.bundle);
    for (InversePoint& point : start.bundle.points) point.inverse_distance = 0;
    adjust_candidate(start, options, own);
  });
  candidates = best_of(std::move(candidates), kFreedStarts);
  for (const double loss : {kLoopGapLoss_px, kSphereTolerance_px}) {
    options.loss_px = sweep.pixels(loss);
    parallel_for(job, static_cast<int>(candidates.size()),
                 [&](int i) { adjust_candidate(candidates[static_cast<size_t>(i)], options, alone); });
  }
  Candidate best = std::move(best_of(std::move(candidates), 1).front());
  for (Pose& pose : best.bundle.cameras) pose.centre = pose.world_from_camera.col(2);
  return std::move(best.bundle);
}

}  // namespace ldp::sfm
