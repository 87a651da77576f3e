#include "core/layers/painting/map_painter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/same_surface.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

static_assert(kernels::kAbsent == kNoDisparity);
static_assert(kernels::kLeastForward == static_cast<float>(kLeastForward));

kernels::Linear linear(double at_0, double at_1) { return {static_cast<float>(at_0), static_cast<float>(at_1 - at_0)}; }

}  // namespace

Brush::Brush(const PanoramaGrid& on, const DisparityMap& layer, const LayersOptions& options)
    : grid(on),
      edges_v(static_cast<size_t>(grid.height) + 1 + kernels::kPadding),
      columns(layer.height + kernels::kPadding, layer.width, kNoDisparity),
      joined(layer.height + kernels::kPadding, layer.width, 0) {
  for (int x = 0; x <= grid.width; ++x) edges.push_back(heading(grid.theta(x)));
  for (int y = 0; y <= grid.height; ++y) edges_v[static_cast<size_t>(y)] = static_cast<float>(grid.v(y));
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

MapPainter::MapPainter(const Brush& brush, const UprightCamera& camera, VisibilityMap& map, SeenPixels* seen,
                       int columns_apart)
    : grid_(brush.grid),
      brush_(brush),
      camera_(camera),
      projection_(grid_, camera),
      map_(map),
      seen_(seen),
      columns_apart_(columns_apart),
      rows_(5 * static_cast<size_t>(brush.columns.width)) {
  const auto rows = [&](int i) { return rows_.data() + static_cast<ptrdiff_t>(i) * brush.columns.width; };
  boxes_ = {rows(0), rows(1), rows(2), rows(3), rows(4)};
}

void MapPainter::paint(int x) {
  const Heading left = brush_.edges[static_cast<size_t>(x)], right = brush_.edges[static_cast<size_t>(x) + 1];
  if (!in_view(left) && !in_view(right)) return;
  const Sides sides{projection_.column(left), projection_.column(right)};
  if (beside_view(sides)) return;
  kernels::best().find_boxes(column(x), projected(sides), brush_.edges_v.data(), grid_.height, boxes_);
  draw_boxes(x);
}

kernels::DisparityColumn MapPainter::column(int x) const {
  const auto or_own = [&](int beside) { return beside < 0 ? x : beside; };
  const int before = or_own(neighbour_column(grid_, x - 1)), after = or_own(neighbour_column(grid_, x + 1));
  return {brush_.columns.row(x), brush_.columns.row(before), brush_.columns.row(after), brush_.joined.row(before),
          brush_.joined.row(x)};
}

kernels::ColumnInView MapPainter::projected(const Sides& sides) const {
  const auto forward = [&](const VoxelProjection::Column& u) {
    return linear(projection_.forward(u, 0), projection_.forward(u, 1));
  };
  const auto across = [&](const VoxelProjection::Column& u) {
    const auto camera_at = [&](double w) {
      return camera_.focal * projection_.right(u, w) + camera_.cx * projection_.forward(u, w);
    };
    // The map's column j is the camera's column j * columns_apart_: their middles lie at the same place.
    const double per_column = 1.0 / columns_apart_, shift = 0.5 - 0.5 * per_column;
    const auto at = [&](double w) { return per_column * camera_at(w) + shift * projection_.forward(u, w); };
    return linear(at(0), at(1));
  };
  const VoxelProjection::Column middle{0.5 * (sides.left.right + sides.right.right),
                                       0.5 * (sides.left.forward + sides.right.forward)};
  return {linear(grid_.inverse_depth(0), grid_.inverse_depth(0.5)),
          forward(middle),
          forward(sides.left),
          forward(sides.right),
          across(sides.left),
          across(sides.right),
          static_cast<float>(camera_.focal),
          static_cast<float>(camera_.cy),
          static_cast<float>(projection_.up(0, 1)),
          static_cast<float>(map_.inverse_z.height),
          static_cast<float>(map_.inverse_z.width),
          static_cast<float>(1 / map_.scale)};
}

// May any voxel of this heading appear in the map?
bool MapPainter::in_view(Heading h) const {
  const auto u = projection_.column(h);
  return u.forward > 0.2 || projection_.forward(u, grid_.w_near) > 0.2;
}

// Does the column stay outside the map at every disparity? Its place in the image is monotonic in inverse depth.
bool MapPainter::beside_view(const Sides& sides) const {
  const double end_px = camera_.width, w_far = grid_.inverse_depth(0), w_near = grid_.inverse_depth(kDisparitySteps);
  const auto always = [&](const VoxelProjection::Column& u, const auto& outside) {
    return projection_.forward(u, w_far) > kLeastForward && projection_.forward(u, w_near) > kLeastForward &&
           outside(projection_.x_px(u, w_far)) && outside(projection_.x_px(u, w_near));
  };
  return always(sides.left, [&](double x_px) { return x_px > end_px + 1; }) ||
         always(sides.right, [](double x_px) { return x_px < -1; });
}

// The innermost loop of all painting: in local variables, so that no pixel it writes makes it read them again.
void MapPainter::draw_boxes(int x) {
  const kernels::Boxes boxes = boxes_;
  const int count = grid_.height, height = map_.inverse_z.width;
  const auto first = static_cast<uint32_t>(x * count);
  uint16_t* const nearest = map_.inverse_z.samples.data();
  uint32_t* const seen = seen_ ? seen_->samples.data() : nullptr;
  for (int y = 0; y < count; ++y) {
    const int end_x = boxes.end_x[y], y0 = boxes.begin_y[y], y1 = boxes.end_y[y];
    if (y0 >= y1) continue;
    const auto nearness = static_cast<uint16_t>(boxes.inverse_z[y]);
    for (int column = boxes.begin_x[y]; column < end_x; ++column) {
      const ptrdiff_t start = static_cast<ptrdiff_t>(column) * height;
      for (ptrdiff_t at = start + y0; at < start + y1; ++at) {
        if (nearest[at] >= nearness) continue;
        nearest[at] = nearness;
        if (seen) seen[at] = first + static_cast<uint32_t>(y);
      }
    }
  }
}

void empty_map(const PanoramaGrid& grid, const UprightCamera& camera, const LayersOptions& options, VisibilityMap& map,
               int columns_apart) {
  const double nearest = std::max(grid.w_near, 1e-9) * 4;  // cameras stand off the ray origins: some room
  assign(map.inverse_z, camera.height, columns_of_map(camera, columns_apart), kUncovered);
  map.scale = nearest / 65535;
  const double label = (grid.w_near - grid.w_far) / (kLabels - 1);
  map.tolerance = static_cast<int>(std::min(65535.0, std::ceil(options.tolerance_labels * label / map.scale)));
}

void continue_farther_surfaces(VisibilityMap& map) {
  Plane<uint16_t>& columns = map.inverse_z;
  constexpr int kNone = -1;
  std::vector<int> covered(static_cast<size_t>(columns.width), kNone);  // of each row, the last column that is
  for (int x = 0; x < columns.height; ++x) {
    const uint16_t* own = columns.row(x);
    for (int y = 0; y < columns.width; ++y) {
      if (own[y] == kUncovered) continue;
      int& last = covered[static_cast<size_t>(y)];
      if (last != kNone && last + 1 < x) {
        const uint16_t farther = std::min(columns.at(y, last), own[y]);
        for (int between = last + 1; between < x; ++between) columns.at(y, between) = farther;
      }
      last = x;
    }
  }
}

}  // namespace ldp::layers
