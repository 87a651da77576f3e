#include "core/poses/adjust/distortion_model.h"

#include <algorithm>

#include "core/poses/adjust/adjust_tuning.h"

namespace ldp::sfm {
std::optional<Bundle> adjust_with_distortion(const Bundle& bundle, BundleAdjustmentOptions options, double cost,
                                             const Job& job) {
  Bundle bent = bundle;
  const double variance = 2 * cost / std::max(1.0, static_cast<double>(bundle.observations.size()));
  options.refine_distortion = true;
  const BundleAdjustmentSummary summary = adjust_bundle(bent, options, job);
  if (!summary.usable || cost - summary.cost <= kMinDistortionGain * variance) return std::nullopt;
  return bent;
}

}  // namespace ldp::sfm
