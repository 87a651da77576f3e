#include <algorithm>
#include <cmath>

#include "core/geometry/same_surface.h"
#include "core/geometry/voxel_projection.h"
#include "core/layers/layers.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

constexpr int kColumnsAtOnce = 64;  // between two looks at the stop token

std::vector<Heading> edge_headings(const PanoramaGrid& grid) {
  std::vector<Heading> edges(static_cast<size_t>(grid.width) + 1);
  for (int x = 0; x <= grid.width; ++x) edges[static_cast<size_t>(x)] = heading(grid.theta(x));
  return edges;
}

// First pixel whose centre lies at or after a position.
int first_pixel(double position_px, int limit) {
  const double pixel = position_px - 0.5;
  if (!(pixel > 0)) return 0;
  if (pixel >= limit) return limit;
  const int whole = static_cast<int>(pixel);
  return whole + (whole < pixel ? 1 : 0);
}

// What painting a layer into any camera's map needs.
struct Brush {
  const PanoramaGrid& grid;
  std::vector<Heading> edges;
  std::vector<double> edges_v;
  std::vector<double> inverse_depths;  // of half disparity steps
  Plane<uint16_t> columns;             // the layer's

  Brush(const PanoramaGrid& on, const DisparityMap& layer)
      : grid(on), edges(edge_headings(on)), columns(layer.height, layer.width) {
    for (int y = 0; y <= grid.height; ++y) edges_v.push_back(grid.v(y));
    for (int i = 0; i <= 2 * kDisparitySteps; ++i) inverse_depths.push_back(grid.inverse_depth(0.5 * i));
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x) columns.at(y, x) = layer.at(x, y);
  }
};

// Draws layers into one camera's map.
class MapPainter {
 public:
  MapPainter(const Brush& brush, const UprightCamera& camera, const LayersOptions& options, VisibilityMap& map)
      : grid_(brush.grid),
        brush_(brush),
        projection_(grid_, camera),
        connected_{parallax_steps(grid_, options.connect_px), options.connect_share,
                   grid_.w_far / std::max(1e-9, grid_.w_near - grid_.w_far) * kDisparitySteps},
        map_(map) {}

  // One column of the layer.
  void paint(int x) {
    const Heading left = brush_.edges[static_cast<size_t>(x)], right = brush_.edges[static_cast<size_t>(x) + 1];
    if (!in_view(left) && !in_view(right)) return;
    const Sides sides{projection_.column(left), projection_.column(right)};
    if (beside_view(sides)) return;
    const int before = neighbour_column(grid_, x - 1), after = neighbour_column(grid_, x + 1);
    const uint16_t *here = brush_.columns.row(x), *to_left = brush_.columns.row(before < 0 ? x : before),
                   *to_right = brush_.columns.row(after < 0 ? x : after);
    for (int y = 0; y < grid_.height; ++y)
      if (const int d = here[y]; d != kNoDisparity)
        paint_pixel(sides, y, shared_edge(d, to_left[y]), d, shared_edge(d, to_right[y]));
  }

 private:
  struct Sides {  // of a column
    VoxelProjection::Column left, right;
  };

  // In half steps.
  int shared_edge(int d, int neighbour) const {
    return neighbour != kNoDisparity && connected_.same_surface(d, neighbour) ? d + neighbour : 2 * d;
  }

  // May any voxel of this heading appear in the map?
  bool in_view(Heading h) const {
    const auto u = projection_.column(h);
    return u.forward > 0.2 || projection_.forward(u, grid_.w_near) > 0.2;
  }

  // Does the column stay outside the map at every disparity? Its place in the image is monotonic in inverse depth.
  bool beside_view(const Sides& sides) const {
    const double end_px = 1.0 * map_.inverse_z.height, w_far = grid_.inverse_depth(0),
                 w_near = grid_.inverse_depth(kDisparitySteps);
    const auto always = [&](const VoxelProjection::Column& u, const auto& outside) {
      return projection_.forward(u, w_far) > 0.1 && projection_.forward(u, w_near) > 0.1 &&
             outside(projection_.x_px(u, w_far)) && outside(projection_.x_px(u, w_near));
    };
    return always(sides.left, [&](double x_px) { return x_px > end_px + 1; }) ||
           always(sides.right, [](double x_px) { return x_px < -1; });
  }

  // Its disparity, and those of its sides in half steps.
  void paint_pixel(const Sides& sides, int y, int left_half_steps, int d, int right_half_steps) {
    const auto& [left, right] = sides;
    const VoxelProjection::Column middle{0.5 * (left.right + right.right), 0.5 * (left.forward + right.forward)};
    const std::vector<double>& depths = brush_.inverse_depths;
    const double w_left = depths[static_cast<size_t>(left_half_steps)], w = depths[static_cast<size_t>(2 * d)],
                 w_right = depths[static_cast<size_t>(right_half_steps)];
    const double forward = projection_.forward(middle, w);
    if (forward < 0.1 || projection_.forward(left, w_left) < 0.1 || projection_.forward(right, w_right) < 0.1) return;
    const int x0 = first_pixel(projection_.x_px(left, w_left), map_.inverse_z.height);
    const int x1 = first_pixel(projection_.x_px(right, w_right), map_.inverse_z.height);
    if (x0 >= x1) return;
    const double slope = projection_.row_slope(forward), offset = projection_.row_offset(w, forward);
    const auto row = static_cast<size_t>(y);
    const int y0 = first_pixel(offset + slope * brush_.edges_v[row], map_.inverse_z.width);
    const int y1 = first_pixel(offset + slope * brush_.edges_v[row + 1], map_.inverse_z.width);
    if (y0 >= y1) return;
    const auto depth = static_cast<uint16_t>(std::clamp(w / forward / map_.scale, 1.0, 65535.0));
    for (int column = x0; column < x1; ++column) {
      uint16_t* out = map_.inverse_z.row(column);
      for (int at = y0; at < y1; ++at) out[at] = std::max(out[at], depth);
    }
  }

  const PanoramaGrid& grid_;
  const Brush& brush_;
  VoxelProjection projection_;
  SurfaceTolerance<double> connected_;  // in disparity steps
  VisibilityMap& map_;
};

VisibilityMap empty_map(const PanoramaGrid& grid, const UprightCamera& camera, const LayersOptions& options) {
  VisibilityMap map;
  const double nearest = std::max(grid.w_near, 1e-9) * 4;  // cameras stand off the ray origins: some room
  map.inverse_z = Plane<uint16_t>(camera.height, camera.width, kUncovered);
  map.scale = nearest / 65535;
  const double label = (grid.w_near - grid.w_far) / (kLabels - 1);
  map.tolerance = static_cast<int>(std::min(65535.0, std::ceil(options.tolerance_labels * label / map.scale)));
  return map;
}

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
    for (const UprightFrame& frame : frames) maps.push_back(empty_map(grid, frame.camera, options));
  const Brush brush(grid, layer);
  parallel_for(job, static_cast<int>(frames.size()), [&](int i) {
    const auto index = static_cast<size_t>(i);
    MapPainter painter(brush, frames[index].camera, options, maps[index]);
    for (int x = 0; x < grid.width; ++x) {
      if (x % kColumnsAtOnce == 0) job.check();
      painter.paint(x);
    }
    close_hairlines(maps[index]);
  });
}

DisparityMap without_silhouettes(const DisparityMap& layer, int reach_px) {
  DisparityMap rows = layer, both = layer;
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const uint16_t* row = layer.row(y);
      rows.at(x, y) = *std::min_element(row + std::max(0, x - reach_px), row + std::min(layer.width, x + reach_px + 1));
    }
  for (int y = 0; y < layer.height; ++y)
    for (int at = std::max(0, y - reach_px); at < std::min(layer.height, y + reach_px + 1); ++at)
      std::transform(both.row(y), both.row(y) + layer.width, rows.row(at), both.row(y),
                     [](uint16_t a, uint16_t b) { return std::min(a, b); });
  return both;
}

}  // namespace ldp
