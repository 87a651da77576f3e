#include "core/poses/adjust/distortion_model.h"

#include <algorithm>

#include "core/poses/adjust/adjust_tuning.h"

namespace ldp::sfm {

double min_distortion_gain(const Bundle& bundle, bool on_klt_tracks) {
  if (!on_klt_tracks) return kMinDistortionGain;
  return kMinKltDistortionGain + kKltDistortionGainPerObservation * static_cast<double>(bundle.observations.size());
}

std::optional<Bundle> adjust_with_distortion(const Bundle& bundle, BundleAdjustmentOptions options, double cost,
                                             double min_gain, const Job& job) {
  Bundle bent = bundle;
  const double variance = 2 * cost / std::max(1.0, static_cast<double>(bundle.observations.size()));
  options.refine_distortion = true;
  const BundleAdjustmentSummary summary = adjust_bundle(bent, options, job);
  if (!summary.usable || cost - summary.cost <= min_gain * variance) return std::nullopt;
  return bent;
}

}  // namespace ldp::sfm
