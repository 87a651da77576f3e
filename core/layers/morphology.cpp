// Greyscale erosion, dilation and translation of disparity.
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

// Of squares that reach so far: of lines of samples twice as long each time, one after another across and down.
template <class Pick>
DisparityMap extreme_around(const PanoramaGrid& grid, const DisparityMap& layer, int reach_px, Pick pick) {
  const int across = std::min(reach_px, layer.width), down = std::min(reach_px, layer.height);
  DisparityMap rows(layer.width, layer.height + 2 * down), out(layer.width, layer.height);
  std::vector<uint16_t> row(static_cast<size_t>(layer.width + 2 * across));
  for (int y = 0; y < layer.height; ++y) {
    for (int x = -across; x < layer.width + across; ++x)
      row[static_cast<size_t>(x + across)] = layer.at(column_beside(grid, x), y);
    const int window = 2 * across + 1;
    int length = 1;
    for (; 2 * length <= window; length *= 2)
      std::transform(row.begin(), row.end() - length, row.begin() + length, row.begin(), pick);
    std::transform(row.begin(), row.begin() + layer.width, row.begin() + window - length, rows.row(y + down), pick);
  }
  for (int y = 0; y < down; ++y) {  // beyond the edge as at it
    std::copy_n(rows.row(down), layer.width, rows.row(y));
    std::copy_n(rows.row(down + layer.height - 1), layer.width, rows.row(down + layer.height + y));
  }
  const int window = 2 * down + 1;
  int length = 1;
  for (; 2 * length <= window; length *= 2)
    for (int y = 0; y + length < rows.height; ++y)
      std::transform(rows.row(y), rows.row(y) + layer.width, rows.row(y + length), rows.row(y), pick);
  for (int y = 0; y < layer.height; ++y)
    std::transform(rows.row(y), rows.row(y) + layer.width, rows.row(y + window - length), out.row(y), pick);
  return out;
}

}  // namespace

DisparityMap farthest_around(const PanoramaGrid& grid, const DisparityMap& layer, int reach_px) {
  return extreme_around(grid, layer, reach_px, [](uint16_t a, uint16_t b) { return std::min(a, b); });
}

DisparityMap nearest_around(const PanoramaGrid& grid, const DisparityMap& layer, int reach_px) {
  constexpr uint16_t kStep = 1;  // absent pixels, which hold the most there is, become the least
  DisparityMap raised = layer;
  for (uint16_t& d : raised.samples) d = static_cast<uint16_t>(d + kStep);
  raised = extreme_around(grid, raised, reach_px, [](uint16_t a, uint16_t b) { return std::max(a, b); });
  for (uint16_t& d : raised.samples) d = static_cast<uint16_t>(d - kStep);
  return raised;
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
