// How exactly colours are worth coding: where depths are wrong exact colours are no gain, and where the photographs are
// explained what coding loses is most of what is left.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/pipeline/pipeline_tuning.h"

namespace ldp::pipeline {

// LdpEncodeOptions::colour_quality of a panorama that has `photos_back_psnr_db` rendered back into its photographs.
inline int colour_quality_for(double photos_back_psnr_db) {
  const double explained = (photos_back_psnr_db - kRoughlyExplained_db) / (kExplained_db - kRoughlyExplained_db);
  return kRoughColour + static_cast<int>(std::lround(std::clamp(explained, 0.0, 1.0) * (kExactColour - kRoughColour)));
}

}  // namespace ldp::pipeline
