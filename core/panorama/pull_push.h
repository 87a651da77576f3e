// Fills in what an image lacks from around it, by pull-push (Gortler et al., The Lumigraph, 1996): known colours are
// averaged into ever coarser images, and drawn back to where there are none. Smooth, without direction, and the same
// for neighbouring views.
#pragma once

#include "core/base/plane.h"

namespace ldp {

struct WeightedColour {
  float r = 0, g = 0, b = 0;  // 0 .. 255, means of what is known
  float weight = 0;           // 0 = unknown .. 1 = known
};

inline WeightedColour known(Rgb c) {
  return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b), 1};
}
Rgb rounded(const WeightedColour& colour);

// All weights are 1 afterwards. Mid-grey where nothing is known at all.
void fill_by_pull_push(Plane<WeightedColour>& image);

}  // namespace ldp
