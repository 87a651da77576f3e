#include "core/layers/proposals/front_greys.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/voxel_projection.h"

namespace ldp::layers {
namespace {

class GreysOfColumn {
 public:
  GreysOfColumn(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames) : grid_(grid), frames_(frames) {
    for (const UprightFrame& frame : frames) projections_.emplace_back(grid, frame.camera);
  }

  // `out` holds them from the top.
  void look(const DisparityMap& layer, int x, int16_t* out) const {
    const Heading h = heading(grid_.theta(x + 0.5));
    std::fill(out, out + layer.height, kUnknownGrey);
    const size_t camera = nearest(h);
    if (camera == frames_.size()) return;
    const VoxelProjection& projection = projections_[camera];
    const VoxelProjection::Column u = projection.column(h);
    for (int y = 0; y < layer.height; ++y) {
      if (layer.at(x, y) == kNoDisparity) continue;
      const double w = grid_.inverse_depth(layer.at(x, y)), forward = projection.forward(u, w);
      if (forward < kLeastForward) continue;
      const double y_px = projection.row_offset(w, forward) + projection.row_slope(forward) * grid_.v(y + 0.5);
      out[y] = grey(frames_[camera], projection.x_px(u, w), y_px);
    }
  }

 private:
  size_t nearest(Heading h) const {
    size_t best = frames_.size();
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < frames_.size(); ++i) {
      const double aside = std::abs(projections_[i].aside(h));
      if (projections_[i].column(h).forward < kLeastForward || aside >= least) continue;
      least = aside;
      best = i;
    }
    return best;
  }

  static int16_t grey(const UprightFrame& frame, double x_px, double y_px) {
    if (!(x_px >= 0 && x_px < frame.camera.width && y_px >= 0 && y_px < frame.camera.height)) return kUnknownGrey;
    const auto column = static_cast<size_t>(x_px);
    const int x = static_cast<int>(x_px), y = static_cast<int>(y_px);
    if (y < frame.valid_begin[column] || y >= frame.valid_end[column]) return kUnknownGrey;
    return frame.columns.row(x)[y];
  }

  const PanoramaGrid& grid_;
  const std::vector<UprightFrame>& frames_;
  std::vector<VoxelProjection> projections_;
};

}  // namespace

Plane<int16_t> front_greys(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& layer,
                           const Job& job) {
  Plane<int16_t> greys(layer.height, layer.width);
  const GreysOfColumn of_column(grid, frames);
  parallel_for(job, layer.width, [&](int x) { of_column.look(layer, x, greys.row(x)); });
  return greys;
}

}  // namespace ldp::layers
