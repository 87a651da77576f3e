#include "lens_bends.h"

#include <algorithm>

namespace ldp {

std::optional<Bundle> bent_lens(const Bundle& bundle, BundleOptions options, double cost, double variances,
                                const Job& job) {
  Bundle bent = bundle;
  const double variance = 2 * cost / std::max(1.0, static_cast<double>(bundle.observations.size()));
  options.refine_distortion = true;
  const BundleSummary summary = adjust(bent, options, job);
  if (!summary.usable || cost - summary.cost <= variances * variance) return std::nullopt;
  return bent;
}

}  // namespace ldp
