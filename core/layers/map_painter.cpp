#include "core/layers/map_painter.h"

#include <cmath>

#include "core/geometry/same_surface.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

// First pixel whose centre lies at or after a position.
int first_pixel(double position_px, int limit) {
  const double pixel = position_px - 0.5;
  if (!(pixel > 0)) return 0;
  if (pixel >= limit) return limit;
  const int whole = static_cast<int>(pixel);
  return whole + (whole < pixel ? 1 : 0);
}

}  // namespace

Brush::Brush(const PanoramaGrid& on, const DisparityMap& layer, const LayersOptions& options)
    : grid(on), columns(layer.height, layer.width), joined(layer.height, layer.width, 0) {
  for (int x = 0; x <= grid.width; ++x) edges.push_back(heading(grid.theta(x)));
  for (int y = 0; y <= grid.height; ++y) edges_v.push_back(grid.v(y));
  for (int i = 0; i <= 2 * kDisparitySteps; ++i) inverse_depths.push_back(grid.inverse_depth(0.5 * i));
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) columns.at(y, x) = layer.at(x, y);
  const SurfaceTolerance<double> connected{parallax_steps(grid, options.connect_px), options.connect_share,
                                           grid.w_far / std::max(1e-9, grid.w_near - grid.w_far) * kDisparitySteps};
  for (int x = 0; x < grid.width; ++x) {
    const int after = neighbour_column(grid, x + 1);
    if (after < 0) continue;
    const uint16_t *here = columns.row(x), *next = columns.row(after);
    for (int y = 0; y < grid.height; ++y)
      joined.at(y, x) = here[y] != kNoDisparity && next[y] != kNoDisparity && connected.same_surface(here[y], next[y]);
  }
}

MapPainter::MapPainter(const Brush& brush, const UprightCamera& camera, VisibilityMap& map, SeenPixels* seen)
    : grid_(brush.grid), brush_(brush), projection_(grid_, camera), map_(map), seen_(seen) {}

void MapPainter::paint(int x) {
  const Heading left = brush_.edges[static_cast<size_t>(x)], right = brush_.edges[static_cast<size_t>(x) + 1];
  if (!in_view(left) && !in_view(right)) return;
  const Sides sides{projection_.column(left), projection_.column(right)};
  if (beside_view(sides)) return;
  const int before = neighbour_column(grid_, x - 1), after = neighbour_column(grid_, x + 1);
  const uint16_t *here = brush_.columns.row(x), *to_left = brush_.columns.row(before < 0 ? x : before),
                 *to_right = brush_.columns.row(after < 0 ? x : after);
  const uint8_t *joined_left = brush_.joined.row(before < 0 ? x : before), *joined_right = brush_.joined.row(x);
  for (int y = 0; y < grid_.height; ++y)
    if (const int d = here[y]; d != kNoDisparity)
      paint_pixel(sides, x, y, d + (joined_left[y] ? to_left[y] : d), d, d + (joined_right[y] ? to_right[y] : d));
}

// May any voxel of this heading appear in the map?
bool MapPainter::in_view(Heading h) const {
  const auto u = projection_.column(h);
  return u.forward > 0.2 || projection_.forward(u, grid_.w_near) > 0.2;
}

// Does the column stay outside the map at every disparity? Its place in the image is monotonic in inverse depth.
bool MapPainter::beside_view(const Sides& sides) const {
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
void MapPainter::paint_pixel(const Sides& sides, int x, int y, int left_half_steps, int d, int right_half_steps) {
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
    if (seen_) {
      uint32_t* seen = seen_->row(column);
      for (int at = y0; at < y1; ++at)
        if (out[at] < depth) seen[at] = static_cast<uint32_t>(x * grid_.height + y);
    }
    for (int at = y0; at < y1; ++at) out[at] = std::max(out[at], depth);
  }
}

void empty_map(const PanoramaGrid& grid, const UprightCamera& camera, const LayersOptions& options,
               VisibilityMap& map) {
  const double nearest = std::max(grid.w_near, 1e-9) * 4;  // cameras stand off the ray origins: some room
  assign(map.inverse_z, camera.height, camera.width, kUncovered);
  map.scale = nearest / 65535;
  const double label = (grid.w_near - grid.w_far) / (kLabels - 1);
  map.tolerance = static_cast<int>(std::min(65535.0, std::ceil(options.tolerance_labels * label / map.scale)));
}

}  // namespace ldp::layers
