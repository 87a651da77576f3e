#include <algorithm>
#include <cmath>

#include "core/layers/layers.h"
#include "core/layers/painting/map_painter.h"

namespace ldp::layers {
namespace {

constexpr int kColumnsAtOnce = 64;  // between two looks at the stop token

// Gaps one pixel high between rows of one surface come from rounding, not from the scene.
void close_hairlines(VisibilityMap& map) {
  for (int column = 0; column < map.inverse_z.height; ++column) {
    uint16_t* out = map.inverse_z.row(column);
    for (int row = 1; row + 1 < map.inverse_z.width; ++row)
      if (out[row] == kUncovered && out[row - 1] != kUncovered && out[row + 1] != kUncovered &&
          std::abs(out[row - 1] - out[row + 1]) <= map.tolerance)
        out[row] = std::min(out[row - 1], out[row + 1]);
  }
}

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

void add_layer(const PanoramaGrid& grid, const DisparityMap& layer, const std::vector<UprightFrame>& frames,
               const LayersOptions& options, const Job& job, std::vector<VisibilityMap>& maps) {
  if (maps.empty())
    for (const UprightFrame& frame : frames) empty_map(grid, frame.camera, options, maps.emplace_back());
  const Brush brush(grid, layer, options);
  parallel_for(job, static_cast<int>(frames.size()), [&](int i) {
    const auto index = static_cast<size_t>(i);
    MapPainter painter(brush, frames[index].camera, maps[index]);
    for (int x = 0; x < grid.width; ++x) {
      if (x % kColumnsAtOnce == 0) job.check();
      painter.paint(x);
    }
    close_hairlines(maps[index]);
  });
}

}  // namespace ldp
