#include "whole_tracks.h"

#include <algorithm>

namespace ldp {
namespace {

constexpr int kWeighings = 3;       // of tracks, each by what the adjustment before left of them
constexpr int kSteps = 3;           // of each adjustment: its weights hold for no longer
constexpr double kNoLoss_px = 1e6;  // the tracks' weights are all there is

// Squared pixels at weight 1 that are left of each track, for each number that its point, of `of_point` numbers, does
// not use up.
std::vector<double> left_of_tracks(const Bundle& bundle, int of_point) {
  std::vector<double> left(bundle.points.size(), 0), numbers(bundle.points.size(), 0);
  for (const BundleObservation& o : bundle.observations) {
    const size_t i = static_cast<size_t>(o.point);
    const Projection p = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens, bundle.points[i]);
    left[i] += (o.weight * (p.position_px - o.position_px)).squaredNorm();
    numbers[i] += 2;
  }
  for (size_t i = 0; i < left.size(); ++i) left[i] /= std::max(1.0, numbers[i] - of_point);
  return left;
}

}  // namespace

void adjust_whole_tracks(Bundle& bundle, BundleOptions options, double scale_px, const Job& job) {
  const std::vector<BundleObservation> given = bundle.observations;
  options.loss_px = kNoLoss_px;
  options.most_iterations = kSteps;
  for (int i = 0; i < kWeighings; ++i) {
    const std::vector<double> left = left_of_tracks(bundle, options.model == Model::rotation ? 2 : 3);
    for (BundleObservation& o : bundle.observations)
      o.weight /= 1 + left[static_cast<size_t>(o.point)] / (scale_px * scale_px);
    adjust(bundle, options, job);
    bundle.observations = given;
  }
}

}  // namespace ldp
