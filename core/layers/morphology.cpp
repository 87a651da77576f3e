// Greyscale erosion and dilation of disparity.
#include <algorithm>

#include "core/layers/layers.h"

namespace ldp {
namespace {

// `choose` of all disparities within the reach of each pixel, both ways.
template <typename Choose>
DisparityMap chosen_within(const DisparityMap& layer, int reach_px, Choose choose) {
  DisparityMap rows = layer, both = layer;
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x)
      for (int at = std::max(0, x - reach_px); at < std::min(layer.width, x + reach_px + 1); ++at)
        rows.at(x, y) = choose(rows.at(x, y), layer.at(at, y));
  both = rows;
  for (int y = 0; y < layer.height; ++y)
    for (int at = std::max(0, y - reach_px); at < std::min(layer.height, y + reach_px + 1); ++at)
      std::transform(both.row(y), both.row(y) + layer.width, rows.row(at), both.row(y), choose);
  return both;
}

}  // namespace

DisparityMap without_silhouettes(const DisparityMap& layer, int reach_px) {
  return chosen_within(layer, reach_px, [](uint16_t a, uint16_t b) { return std::min(a, b); });
}

DisparityMap widened(const DisparityMap& layer, int reach_px) {
  // Where a pixel is absent it is what lies beside it.
  return chosen_within(layer, reach_px, [](uint16_t a, uint16_t b) {
    return a == kNoDisparity || b == kNoDisparity ? std::min(a, b) : std::max(a, b);
  });
}

}  // namespace ldp
