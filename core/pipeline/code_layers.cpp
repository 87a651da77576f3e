#include "core/pipeline/code_layers.h"

#include <algorithm>
#include <cstddef>

#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

using namespace pipeline;  // tuned constants

int steps_of_parallax(const PanoramaGrid& grid, double px) {
  LayersOptions options;
  options.gap_px = px;
  return gap_steps(grid, options);
}

void drop_inseparable(const Plane<int16_t>& farthest, DisparityMap& layer) {
  for (size_t i = 0; i < layer.samples.size(); ++i)
    if (layer.samples[i] != kNoDisparity && layer.samples[i] > farthest.samples[i]) layer.samples[i] = kNoDisparity;
}

void drop_sources(const DisparityMap& layer, SourceMap& source) {
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x)
      if (layer.at(x, y) == kNoDisparity) source.set(x, y, kNoSource);
}

Layer coded(const DisparityMap& disparity, int block_px, int known_steps) {
  Layer layer;
  layer.depth = encode_depth(disparity, block_px, known_steps);
  layer.coverage = Plane<uint8_t>(disparity.width, disparity.height, 0);
  for (size_t i = 0; i < disparity.samples.size(); ++i)
    layer.coverage.samples[i] = disparity.samples[i] != kNoDisparity;
  layer.colour = RgbImage(disparity.width, disparity.height);
  return layer;
}

// Surfaces less than two codes apart are one to a renderer.
void move_back(const Layer& layer, int separate, Plane<int16_t>& farthest) {
  for (int y = 0; y < farthest.height; ++y)
    for (int x = 0; x < farthest.width; ++x) {
      if (!layer.coverage.at(x, y)) continue;
      const BlockRange range = layer.depth.range(x, y);
      const int apart = std::max(separate, 2 * (range.high - range.low));
      farthest.at(x, y) = static_cast<int16_t>(layer.depth.disparity(x, y) - apart);
    }
}

}  // namespace

std::vector<Layer> code_layers(const PanoramaGrid& grid, int columns_of_colour, int block_px,
                               std::vector<DisparityMap>& layers, std::vector<SourceMap>& sources) {
  std::vector<Layer> all;
  Plane<int16_t> farthest(grid.width, grid.height, kDisparitySteps);  // disparity at most that the next layer shows
  for (size_t k = 0; k < layers.size(); ++k) {
    drop_inseparable(farthest, layers[k]);
    if (k > 0) drop_small_components(kSpeckPx * columns_of_colour, grid.wraps, layers[k]);
    drop_sources(layers[k], sources[k]);
    all.push_back(coded(layers[k], block_px, steps_of_parallax(grid, k == 0 ? kKnownPx : 2 * kKnownPx)));
    move_back(all[k], steps_of_parallax(grid, kSeparatePx), farthest);
  }
  return all;
}

}  // namespace ldp
