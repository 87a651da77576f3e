#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

// The background met last while walking along a row through wanted pixels.
struct Continued {
  int disparity = -1, distance = 0;
  void step(uint8_t want, int surface) {
    if (want == kBoundary)
      disparity = surface, distance = 0;
    else if (want == kWanted && disparity >= 0)
      ++distance;
    else
      disparity = -1;
  }
};

// Between the backgrounds of both sides by distance; -1 = there is none.
int between(const Continued& a, const Continued& b) {
  if (a.disparity < 0 || b.disparity < 0) return std::max(a.disparity, b.disparity);
  if (std::abs(a.disparity - b.disparity) > kLabelSteps) return a.distance <= b.distance ? a.disparity : b.disparity;
  return (a.disparity * b.distance + b.disparity * a.distance) / std::max(1, a.distance + b.distance);
}

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

int gap_steps(const PanoramaGrid& grid, const LayersOptions& options) {
  return static_cast<int>(std::clamp(std::ceil(parallax_steps(grid, options.gap_px)), 1.0, 1.0 * kLabelSteps));
}

void continue_background(const Plane<uint8_t>& want, const DisparityMap& surface, int gap, DisparityMap& layer) {
  std::vector<Continued> from_right(static_cast<size_t>(layer.width));
  for (int y = 0; y < layer.height; ++y) {
    Continued walk;
    for (int x = layer.width - 1; x >= 0; --x) {
      walk.step(want.at(x, y), surface.at(x, y));
      from_right[static_cast<size_t>(x)] = walk;
    }
    walk = {};
    for (int x = 0; x < layer.width; ++x) {
      walk.step(want.at(x, y), surface.at(x, y));
      if (want.at(x, y) != kWanted) continue;
      const int d = between(walk, from_right[static_cast<size_t>(x)]);
      uint16_t& out = layer.at(x, y);
      const bool agrees = out == kNoDisparity || std::abs(out - d) <= kLabelSteps;
      if (d >= 0 && d + gap <= surface.at(x, y) && agrees) out = static_cast<uint16_t>(d);
    }
  }
}

void smooth_behind(const PanoramaGrid& grid, const DisparityMap& surface, int gap, int reach_px, const Job& job,
                   DisparityMap& layer) {
  const DisparityMap before = layer;
  parallel_for(job, layer.width, [&](int x) {
    std::vector<int> columns;
    for (int i = -reach_px; i <= reach_px; ++i)
      if (const int column = neighbour_column(grid, x + i); column >= 0) columns.push_back(column);
    std::vector<uint16_t> around;
    for (int y = 0; y < layer.height; ++y) {
      if (before.at(x, y) == kNoDisparity) continue;
      around.clear();
      for (int row = std::max(0, y - reach_px); row <= std::min(layer.height - 1, y + reach_px); ++row)
        for (const int column : columns)
          if (const uint16_t d = before.at(column, row); d != kNoDisparity) around.push_back(d);
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
      std::nth_element(around.begin(), middle, around.end());
      if (*middle + gap <= surface.at(x, y)) layer.at(x, y) = *middle;
    }
  });
}

void BoundaryCosts::read(const Window& window, uint8_t* cost, uint8_t* median) const {
  inner_.read(window, cost, median);
  const int labels = inner_.labels();
  for (int i = 0; i < window.width; ++i) {
    const int x = (window.x + i) % inner_.width();
    for (int j = 0; j < window.height; ++j) {
      const int y = window.y + j;
      const uint8_t want = want_.at(x, y);
      uint8_t* out = cost + (static_cast<size_t>(i) * static_cast<size_t>(window.height) + static_cast<size_t>(j)) *
                                static_cast<size_t>(labels);
      if (want == kBoundary) {
        const int held = (surface_.at(x, y) * (labels - 1) + kDisparitySteps / 2) / kDisparitySteps;
        for (int l = 0; l < labels; ++l) out[l] = l == held ? 0 : 255;
      } else if (want == kWanted && likely_.at(x, y) != kNoDisparity) {
        for (int l = 0; l * kDisparitySteps < likely_.at(x, y) * (labels - 1); ++l)
          out[l] = static_cast<uint8_t>(std::min(255, out[l] + tuning::kUnlikelyPrice));
      }
    }
  }
}

DisparityMap likely_behind(const PanoramaGrid& grid, const DisparityMap& front, int reach_px) {
  DisparityMap likely = farthest_around(grid, front, reach_px);
  const int apart = static_cast<int>(parallax_steps(grid, tuning::kApartPx));
  for (uint16_t& d : likely.samples)
    if (d != kNoDisparity) d = static_cast<uint16_t>(std::max(0, d - apart));
  return likely;
}

}  // namespace ldp
