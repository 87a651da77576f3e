#include <cstdlib>

#include "core/geometry/same_surface.h"
#include "core/layers/layers.h"

namespace ldp::layers {
namespace {

constexpr SurfaceTolerance<int> kOneSurface{kLabelSteps / 2 - 1};  // less than half a label

// Between `own`, where its column has its middle, and `beside` one column away, at `share` of `shares` on that way.
uint16_t between(int own, int beside, int share, int shares) {
  return static_cast<uint16_t>((own * (shares - share) + beside * share + shares / 2) / shares);
}

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

DisparityMap with_finer_columns(const DisparityMap& layer, int times, bool wraps) {
  DisparityMap finer(layer.width * times, layer.height, kNoDisparity);
  const int shares = 2 * times;
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const int own = layer.at(x, y);
      if (own == kNoDisparity) continue;
      for (int k = 0; k < times; ++k) {
        const int right_of_middle = 2 * k + 1 - times;  // in shares
        int beside = right_of_middle < 0 ? x - 1 : x + 1;
        if (wraps) beside = (beside + layer.width) % layer.width;
        const int other = beside >= 0 && beside < layer.width ? layer.at(beside, y) : kNoDisparity;
        const bool one_surface = other != kNoDisparity && kOneSurface.same_surface(own, other);
        finer.at(x * times + k, y) =
            one_surface ? between(own, other, std::abs(right_of_middle), shares) : static_cast<uint16_t>(own);
      }
    }
  return finer;
}

}  // namespace ldp
