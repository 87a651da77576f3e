// How exactly colours are worth coding: where depths are wrong exact colours are no gain, and where the photographs are
// explained what coding loses is most of what is left (figures: decisions.md).
#pragma once

#include <algorithm>
#include <cmath>

namespace ldp {

// LdpEncodeOptions::colour_quality of a panorama that has `photos_back_psnr_db` rendered back into its photographs.
inline int colour_quality_for(double photos_back_psnr_db) {
  constexpr double kRoughlyExplained_db = 28, kExplained_db = 31;
  constexpr int kRough = 90, kExact = 95;
  const double explained = (photos_back_psnr_db - kRoughlyExplained_db) / (kExplained_db - kRoughlyExplained_db);
  return kRough + static_cast<int>(std::lround(std::clamp(explained, 0.0, 1.0) * (kExact - kRough)));
}

}  // namespace ldp
