#include "core/poses/adjust/distortion_model.h"

#include <algorithm>

namespace ldp {
namespace {

constexpr double kBends = 100;  // variances of an observation by which freeing distortion must lower the cost

}  // namespace

std::optional<Bundle> bent_lens(const Bundle& bundle, BundleOptions options, double cost, const Job& job) {
  Bundle bent = bundle;
  const double variance = 2 * cost / std::max(1.0, static_cast<double>(bundle.observations.size()));
  options.refine_distortion = true;
  const BundleSummary summary = adjust(bent, options, job);
  if (!summary.usable || cost - summary.cost <= kBends * variance) return std::nullopt;
  return bent;
}

}  // namespace ldp
