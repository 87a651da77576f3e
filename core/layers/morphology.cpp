// Greyscale erosion and translation of disparity.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/layers/layers.h"
#include "core/layers/neighbours.h"

namespace ldp {

namespace {

// What stands beside the panorama: where it wraps its other end, else its edge.
int column_beside(const PanoramaGrid& grid, int x) {
  const int inside = layers::neighbour_column(grid, x);
  return inside < 0 ? std::clamp(x, 0, grid.width - 1) : inside;
}

}  // namespace

DisparityMap without_silhouettes(const PanoramaGrid& grid, const DisparityMap& layer, int reach_px) {
  const int reach = std::min(reach_px, layer.width);
  DisparityMap rows = layer, both;
  const std::ptrdiff_t window = 2 * std::ptrdiff_t{reach} + 1;
  std::vector<uint16_t> row(static_cast<size_t>(layer.width + 2 * reach));
  for (int y = 0; y < layer.height; ++y) {
    for (int x = -reach; x < layer.width + reach; ++x)
      row[static_cast<size_t>(x + reach)] = layer.at(column_beside(grid, x), y);
    for (int x = 0; x < layer.width; ++x) rows.at(x, y) = *std::min_element(row.begin() + x, row.begin() + x + window);
  }
  both = rows;
  for (int y = 0; y < layer.height; ++y)
    for (int at = std::max(0, y - reach_px); at < std::min(layer.height, y + reach_px + 1); ++at)
      std::transform(both.row(y), both.row(y) + layer.width, rows.row(at), both.row(y),
                     [](uint16_t a, uint16_t b) { return std::min(a, b); });
  return both;
}

DisparityMap shifted(const PanoramaGrid& grid, const DisparityMap& layer, int right, int down) {
  DisparityMap result(layer.width, layer.height);
  std::vector<int> from;
  for (int x = 0; x < layer.width; ++x) from.push_back(column_beside(grid, x + right));
  for (int y = 0; y < layer.height; ++y) {
    const uint16_t* row = layer.row(std::clamp(y + down, 0, layer.height - 1));
    for (int x = 0; x < layer.width; ++x) result.at(x, y) = row[from[static_cast<size_t>(x)]];
  }
  return result;
}

}  // namespace ldp
