#include "core/poses/adjust/robust_tracks.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ldp {
namespace {

constexpr double kNoLoss_px = 1e6;               // the tracks' weights are all there is
constexpr double kNarrow = 0.3, kBetween = 0.5;  // scales, pixels of 800: the deviation of a feature, and what judges
constexpr double kClearly = 30 * kNarrow * kNarrow;  // squared pixels of 800: thirty variances of a feature
constexpr double kFreely = 1e6;                      // first trust region where what few points tie is to settle

// How often tracks are weighed, each time by what the adjustment before left of them, and how.
struct Weighing {
  double scale_px = 0;
  int times = 3;
  int steps = 3;          // of each adjustment: its weights hold for no longer
  bool same_sum = false;  // of squared shares as of ones, so that priors count no more than before
};

// Of each track: squared pixels at weight 1 that are left of it, and the numbers that its point does not use up.
struct Left {
  double squared_px = 0, numbers = 0;
  double of_each() const { return squared_px / std::max(1.0, numbers); }
};

std::vector<Left> left_of_tracks(const Bundle& bundle, Model model) {
  const double of_point = model == Model::rotation ? 2 : 3;
  std::vector<Left> left(bundle.points.size(), {0, -of_point});
  for (const BundleObservation& o : bundle.observations) {
    const size_t i = static_cast<size_t>(o.point);
    const Projection p = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens, bundle.points[i]);
    left[i].squared_px += (o.weight * (p.position_px - o.position_px)).squaredNorm();
    left[i].numbers += 2;
  }
  return left;
}

void weigh(Bundle& bundle, Model model, const Weighing& weighing) {
  const std::vector<Left> left = left_of_tracks(bundle, model);
  double squares = 0;
  for (BundleObservation& o : bundle.observations) {
    const double less = 1 + left[static_cast<size_t>(o.point)].of_each() / (weighing.scale_px * weighing.scale_px);
    o.weight /= less;
    squares += 1 / (less * less);
  }
  if (!weighing.same_sum) return;
  const double all = std::sqrt(static_cast<double>(bundle.observations.size()) / squares);
  for (BundleObservation& o : bundle.observations) o.weight *= all;
}

void adjust_weighed(Bundle& bundle, BundleOptions options, const Weighing& weighing, const Job& job) {
  const std::vector<BundleObservation> given = bundle.observations;
  options.loss_px = kNoLoss_px;
  options.most_iterations = weighing.steps;
  for (int i = 0; i < weighing.times; ++i) {
    weigh(bundle, options.model, weighing);
    adjust(bundle, options, job);
    bundle.observations = given;
  }
}

// Squared pixels at weight 1 that tracks leave unexplained; none more than the scale squared for each of its numbers.
double unexplained(const Bundle& bundle, Model model, double scale_px) {
  const double square = scale_px * scale_px;
  double sum = 0;
  for (const Left& left : left_of_tracks(bundle, model)) {
    if (left.numbers > 0) sum += left.numbers * square * left.of_each() / (square + left.of_each());
  }
  return sum;
}

}  // namespace

void adjust_whole_tracks(Bundle& bundle, BundleOptions options, double scale_px, const Job& job) {
  adjust_weighed(bundle, options, Weighing{.scale_px = scale_px}, job);
}

bool adjust_narrowly(Bundle& bundle, BundleOptions options, double pixel, const Job& job) {
  Bundle narrow = bundle;
  options.first_trust = kFreely;
  adjust_weighed(narrow, options, Weighing{.scale_px = kNarrow * pixel, .times = 10, .steps = 6, .same_sum = true},
                 job);
  const auto still_unexplained = [&](const Bundle& b) { return unexplained(b, options.model, kBetween * pixel); };
  if (!(still_unexplained(narrow) < still_unexplained(bundle) - kClearly * pixel * pixel)) return false;
  bundle = std::move(narrow);
  return true;
}

}  // namespace ldp
