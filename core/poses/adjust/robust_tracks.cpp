#include "core/poses/adjust/robust_tracks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/poses/adjust/adjust_tuning.h"

namespace ldp::sfm {
namespace {

// How often tracks are weighed, each time by what the adjustment before left of them, and how.
struct ReweightingOptions {
  double scale_px = 0;
  int times = kTrackReweightings;
  int steps = kStepsPerReweighting;  // of each adjustment: its weights hold for no longer
  bool keep_sum = false;             // of squared shares as of ones, so that priors count no more than before
};

// Of each track: squared pixels at weight 1 that are left of it, and the degrees_of_freedom that its point does not use
// up.
struct TrackResidual {
  double squared_px = 0, degrees_of_freedom = 0;
  double variance() const { return squared_px / std::max(1.0, degrees_of_freedom); }
};

std::vector<TrackResidual> track_residuals(const Bundle& bundle, MotionModel model) {
  const double of_point = model == MotionModel::rotation ? 2 : 3;
  std::vector<TrackResidual> residuals(bundle.points.size(), {0, -of_point});
  for (const BundleObservation& o : bundle.observations) {
    const size_t i = static_cast<size_t>(o.point);
    const Projection p = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens, bundle.points[i]);
    residuals[i].squared_px += (o.weight * (p.position_px - o.position_px)).squaredNorm();
    residuals[i].degrees_of_freedom += 2;
  }
  return residuals;
}

void reweight(Bundle& bundle, MotionModel model, const ReweightingOptions& reweighting) {
  const std::vector<TrackResidual> residuals = track_residuals(bundle, model);
  double squares = 0;
  for (BundleObservation& o : bundle.observations) {
    const double less =
        1 + residuals[static_cast<size_t>(o.point)].variance() / (reweighting.scale_px * reweighting.scale_px);
    o.weight /= less;
    squares += 1 / (less * less);
  }
  if (!reweighting.keep_sum) return;
  const double all = std::sqrt(static_cast<double>(bundle.observations.size()) / squares);
  for (BundleObservation& o : bundle.observations) o.weight *= all;
}

void adjust_reweighted(Bundle& bundle, BundleAdjustmentOptions options, const ReweightingOptions& reweighting,
                       const Job& job) {
  const std::vector<BundleObservation> given = bundle.observations;
  options.loss_px = kNoLoss_px;
  options.max_iterations = reweighting.steps;
  for (int i = 0; i < reweighting.times; ++i) {
    reweight(bundle, options.model, reweighting);
    adjust_bundle(bundle, options, job);
    bundle.observations = given;
  }
}

// Squared pixels at weight 1 that tracks leave unexplained; none more than the scale squared for each of its
// degrees_of_freedom.
double robust_cost(const Bundle& bundle, MotionModel model, double scale_px) {
  const double square = scale_px * scale_px;
  double sum = 0;
  for (const TrackResidual& residual : track_residuals(bundle, model)) {
    if (residual.degrees_of_freedom > 0)
      sum += residual.degrees_of_freedom * square * residual.variance() / (square + residual.variance());
  }
  return sum;
}

}  // namespace

void adjust_with_track_weights(Bundle& bundle, BundleAdjustmentOptions options, double scale_px, const Job& job) {
  adjust_reweighted(bundle, std::move(options), ReweightingOptions{.scale_px = scale_px}, job);
}

bool adjust_with_narrow_track_weights(Bundle& bundle, BundleAdjustmentOptions options, double pixel, const Job& job) {
  Bundle narrow = bundle;
  options.initial_trust_region_radius = kWideTrustRegion;
  adjust_reweighted(narrow, options,
                    ReweightingOptions{.scale_px = kNarrowScale_px * pixel,
                                       .times = kNarrowReweightings,
                                       .steps = kStepsPerNarrowReweighting,
                                       .keep_sum = true},
                    job);
  const auto cost_of = [&](const Bundle& b) { return robust_cost(b, options.model, kComparisonScale_px * pixel); };
  if (!(cost_of(narrow) < cost_of(bundle) - kMinNarrowGain_px2 * pixel * pixel)) return false;
  bundle = std::move(narrow);
  return true;
}

}  // namespace ldp::sfm
