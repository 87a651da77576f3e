// Wires before the sky are darker than what is around them, and gaps between leaves lighter, or the other way round:
// what is alike in that is mostly of one surface.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/voxel_projection.h"
#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp {
namespace {

using namespace layers;

constexpr int kUnknown = -1;

// What the camera next to a column's rays shows of its pixels; kUnknown where it shows nothing.
class GreysOfColumn {
 public:
  GreysOfColumn(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames) : grid_(grid), frames_(frames) {
    for (const UprightFrame& frame : frames) projections_.emplace_back(grid, frame.camera);
  }

  // `out` holds them column by column.
  void look(const DisparityMap& layer, int x, int16_t* out) const {
    const Heading h = heading(grid_.theta(x + 0.5));
    std::fill(out, out + layer.height, int16_t{kUnknown});
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
    if (!(x_px >= 0 && x_px < frame.camera.width && y_px >= 0 && y_px < frame.camera.height)) return kUnknown;
    const auto column = static_cast<size_t>(x_px);
    const int x = static_cast<int>(x_px), y = static_cast<int>(y_px);
    if (y < frame.valid_begin[column] || y >= frame.valid_end[column]) return kUnknown;
    return frame.columns.row(x)[y];
  }

  const PanoramaGrid& grid_;
  const std::vector<UprightFrame>& frames_;
  std::vector<VoxelProjection> projections_;
};

// Sum and number of what is known.
struct Known {
  int sum = 0, count = 0;
  void add(int grey, int times) {
    if (grey == kUnknown) return;
    sum += times * grey;
    count += times;
  }
};

}  // namespace

Plane<Lightness> lightness(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& layer,
                           int reach_px, const Job& job) {
  Plane<int16_t> greys(layer.height, layer.width);  // column by column, as the rest
  const GreysOfColumn of_column(grid, frames);
  parallel_for(job, layer.width, [&](int x) { of_column.look(layer, x, greys.row(x)); });
  Plane<Lightness> found(layer.width, layer.height, Lightness::as_around);
  parallel_for(job, layer.width, [&](int x) {
    std::vector<Known> rows(static_cast<size_t>(layer.height));
    for (int beside = x - reach_px; beside <= x + reach_px; ++beside) {
      const int column = neighbour_column(grid, beside);
      for (int y = 0; column >= 0 && y < layer.height; ++y) rows[static_cast<size_t>(y)].add(greys.row(column)[y], 1);
    }
    Known square;
    const auto add = [&](int y, int times) {
      if (y < 0 || y >= layer.height) return;
      square.sum += times * rows[static_cast<size_t>(y)].sum;
      square.count += times * rows[static_cast<size_t>(y)].count;
    };
    for (int y = 0; y < reach_px; ++y) add(y, 1);
    for (int y = 0; y < layer.height; ++y) {
      add(y + reach_px, 1);
      add(y - reach_px - 1, -1);
      const int own = greys.row(x)[y];
      if (own == kUnknown) continue;
      const int differs = own * square.count - square.sum, enough = tuning::kLightnessDiffers * square.count;
      if (std::abs(differs) > enough) found.at(x, y) = differs > 0 ? Lightness::lighter : Lightness::darker;
    }
  });
  return found;
}

}  // namespace ldp
