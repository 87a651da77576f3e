// Greyscale erosion and translation of disparity.
#include <algorithm>

#include "core/layers/layers.h"
#include "core/layers/neighbours.h"

namespace ldp {

DisparityMap without_silhouettes(const DisparityMap& layer, int reach_px) {
  DisparityMap rows = layer, both;
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x)
      for (int at = std::max(0, x - reach_px); at < std::min(layer.width, x + reach_px + 1); ++at)
        rows.at(x, y) = std::min(rows.at(x, y), layer.at(at, y));
  both = rows;
  for (int y = 0; y < layer.height; ++y)
    for (int at = std::max(0, y - reach_px); at < std::min(layer.height, y + reach_px + 1); ++at)
      std::transform(both.row(y), both.row(y) + layer.width, rows.row(at), both.row(y),
                     [](uint16_t a, uint16_t b) { return std::min(a, b); });
  return both;
}

DisparityMap shifted(const PanoramaGrid& grid, const DisparityMap& layer, int right, int down) {
  DisparityMap result(layer.width, layer.height);
  for (int x = 0; x < layer.width; ++x) {
    const int inside = layers::neighbour_column(grid, x + right);
    const int from = inside < 0 ? std::clamp(x + right, 0, layer.width - 1) : inside;
    for (int y = 0; y < layer.height; ++y) result.at(x, y) = layer.at(from, std::clamp(y + down, 0, layer.height - 1));
  }
  return result;
}

}  // namespace ldp
