#include "core/poses/refine/iterative_refinement.h"

#include <algorithm>
#include <cmath>

#include "core/poses/adjust/adjust_tuning.h"
#include "core/poses/adjust/depth_outliers.h"
#include "core/poses/adjust/distortion_model.h"
#include "core/poses/adjust/robust_tracks.h"
#include "core/poses/refine/refine_tuning.h"
#include "core/poses/start/rotation_averaging.h"
#include "core/poses/start/start_tuning.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

bool is_klt_tolerance(double tolerance) {
  return tolerance == kKltTolerances_px[0] || tolerance == kKltTolerances_px[1];
}

}  // namespace

std::vector<int> observations_by_frame(const Reconstruction& r) {
  std::vector<int> observed(r.left_out.size(), 0);
  for (const BundleObservation& o : r.bundle.observations) ++observed[static_cast<size_t>(o.camera)];
  return observed;
}

double scatter_about_arc(const Reconstruction& r) {
  const std::vector<int> observed = observations_by_frame(r);
  double squared = 0, numbers = 0;
  for (size_t i = 0; i < observed.size(); ++i) {
    if (observed[i] == 0) continue;
    const Pose& pose = r.bundle.cameras[i];
    squared += (pose.centre - pose.world_from_camera.col(2)).squaredNorm();
    numbers += 3;
  }
  return std::sqrt(squared / std::max(numbers, 1.0));
}

double share_beyond_infinity(const Bundle& bundle) {
  const auto beyond = [](const InversePoint& point) { return point.inverse_distance < kBehindInfinity; };
  const auto count = std::count_if(bundle.points.begin(), bundle.points.end(), beyond);
  return static_cast<double>(count) / static_cast<double>(std::max<size_t>(1, bundle.points.size()));
}

IterativeRefinement::IterativeRefinement(const MatchedSweep& sweep, const std::optional<FocalPrior>& focal,
                                         const Job& job)
    : sweep_(&sweep), job_(job) {
  options_.focal_prior = focal;
}

void IterativeRefinement::iterate(const std::vector<Track>& tracks, double tolerance, double arc_sigma,
                                  Reconstruction& r) {
  triangulate(tracks, tolerance, r);
  if (tolerance <= kKltTolerances_px[0] && options_.model != MotionModel::rotation) reject_depth_outliers(r);
  const double loss = sweep_->pixels(std::min(kLossPerTolerance * tolerance, kMaxLoss_px));
  on_klt_tracks_ = is_klt_tolerance(tolerance);
  options_.loss_px = (on_klt_tracks_ ? kKltLossShare : 1) * loss;
  const bool last = tolerance == kKltTolerances_px[1];
  options_.arc_sigma = std::max({arc_sigma, min_arc_sigma_, on_klt_tracks_ ? estimated_arc_sigma_ : 0});
  options_.two_view_weight = trusts_two_view_points_ || last     ? 1
                             : tolerance == kKltTolerances_px[0] ? kKltTwoViewWeight
                                                                 : kMatchTwoViewWeight;
  options_.correct_curvature = tolerance <= kKltTolerances_px[0];
  options_.function_tolerance = tolerance > kFineTolerance_px      ? kCoarseFunctionTolerance
                                : tolerance > kKltTolerances_px[1] ? kMediumFunctionTolerance
                                                                   : kFineFunctionTolerance;
  options_.step_priors = on_klt_tracks_ || options_.model == MotionModel::rotation
                             ? std::vector<StepPrior>{}
                             : step_priors(*sweep_, r.bundle.lens.focal_px);
  cost_ = adjust_bundle(r.bundle, options_, job_).cost;
  if (last && reweights_at_end_) {
    adjust_with_track_weights(r.bundle, options_, sweep_->pixels(kTrackScale_px), job_);
    adjust_with_narrow_track_weights(r.bundle, options_, sweep_->pixels(1), job_);
  }
  estimated_arc_sigma_ = options_.model == MotionModel::free ? scatter_about_arc(r) / noise_px(r) : 0;
}

// Deviation of a coordinate of an observation of weight 1, by what the adjustment left: its cost is half the sum over
// both coordinates of all.
double IterativeRefinement::noise_px(const Reconstruction& r) const {
  const double count = static_cast<double>(r.bundle.observations.size());
  return std::max(std::sqrt(cost_ / std::max(1.0, count)), sweep_->pixels(kMinNoise_px));
}

bool IterativeRefinement::select_distortion_model(Reconstruction& r) {
  if (options_.refine_distortion) return false;
  BundleAdjustmentOptions options = options_;
  if (on_klt_tracks_) {  // focal length and distortion stand in for each other: a long way, nearly level
    options.function_tolerance = kFineFunctionTolerance;
    options.initial_trust_region_radius = kWideTrustRegion;
  }
  const double min_gain = min_distortion_gain(r.bundle, on_klt_tracks_);
  std::optional<Bundle> distorted = adjust_with_distortion(r.bundle, options, cost_, min_gain, job_);
  if (!distorted) return false;
  r.bundle = std::move(*distorted);
  options_.refine_distortion = true;
  return true;
}

void IterativeRefinement::triangulate(const std::vector<Track>& tracks, double tolerance, Reconstruction& r) const {
  r.tracks =
      triangulate_inliers(tracks, sweep_->pixels(tolerance), options_.model == MotionModel::rotation, r.bundle, job_);
}

// Where a frame has more than a few.
void IterativeRefinement::reject_depth_outliers(Reconstruction& r) const {
  const std::vector<bool> outliers = depth_outliers(r.tracks, r.bundle, sweep_->pixels(kDepthOutlier_px));
  const std::vector<int> observed = observations_by_frame(r);
  std::vector<Track> kept;
  Bundle bundle = r.bundle;
  bundle.points.clear();
  bundle.observations.clear();
  for (size_t i = 0; i < outliers.size(); ++i) {
    const auto poor = [&](const Observation& o) { return observed[static_cast<size_t>(o.frame)] < kWellObserved; };
    if (outliers[i] && std::none_of(r.tracks[i].begin(), r.tracks[i].end(), poor)) continue;
    add_point(r.tracks[i], r.bundle.points[i], bundle);
    kept.push_back(std::move(r.tracks[i]));
  }
  r.tracks = std::move(kept);
  r.bundle = std::move(bundle);
}

}  // namespace ldp::sfm
