#include "core/view/raster/view_frustum.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/exact_math.h"
#include "core/geometry/voxel_projection.h"

namespace ldp::view {
namespace {

// The largest squared radius up to which the radial distortion grows with the radius.
float largest_r2(const Intrinsics& k) {
  constexpr double kStep = 0.01, kLargest = 10;
  for (int step = 0; step < kLargest / kStep; ++step) {
    const double r = step * kStep;
    const double slope = 1 + r * r * (3 * k.k1 + 5 * k.k2 * r * r);
    if (slope <= 0.05) return static_cast<float>(r * r);
  }
  return static_cast<float>(kLargest * kLargest);
}

}  // namespace

ViewFrustum::ViewFrustum(const PanoramaGrid& grid, int first_row, int rows, const Camera& camera)
    : intrinsics_(camera.intrinsics), last_column_(grid.width) {
  // The arc's axes and centre as the camera sees them.
  const auto in_camera = [&](const Eigen::Vector3d& in_world) {
    const Eigen::Vector3d x = exact_transposed_product(camera.pose.world_from_camera, in_world);
    const auto snapped = [](double value) { return kept(value, Rounding::snapped); };
    return Eigen::Vector3d(snapped(x.x()), snapped(x.y()), snapped(x.z()));
  };
  const Eigen::Matrix3d& axes = grid.arc.world_from_arc;
  const Eigen::Vector3d ahead = in_camera(axes.col(0)), aside = in_camera(axes.col(1)), n = in_camera(axes.col(2)),
                        centre = in_camera(grid.arc.centre - camera.pose.centre);
  nx_ = static_cast<float>(n.x()), ny_ = static_cast<float>(n.y()), nz_ = static_cast<float>(n.z());
  const size_t columns = static_cast<size_t>(grid.width) + 1;
  for (auto* table : {&ax_, &ay_, &az_, &bx_, &by_, &bz_, &b_length_}) table->resize(columns + kTilePx);
  for (size_t x = 0; x < columns; ++x) {
    const size_t ray = grid.wraps && x + 1 == columns ? 0 : x;
    const Heading u = heading(grid.theta(static_cast<double>(ray) + 0.5));
    const Eigen::Vector3d a = u.cos * ahead + u.sin * aside;
    const Eigen::Vector3d b = grid.ray_radius() * a + centre;
    ax_[x] = static_cast<float>(a.x()), ay_[x] = static_cast<float>(a.y()), az_[x] = static_cast<float>(a.z());
    bx_[x] = static_cast<float>(b.x()), by_[x] = static_cast<float>(b.y()), bz_[x] = static_cast<float>(b.z());
    b_length_[x] = static_cast<float>(b.norm());
  }
  for (int y = first_row; y < first_row + rows; ++y) v_.push_back(static_cast<float>(grid.v(y + 0.5)));
  const Intrinsics& k = intrinsics_;
  const auto number = [](double value) { return static_cast<float>(value); };
  lens_ = {number(k.fx), number(k.fy), number(k.cx), number(k.cy),  number(k.k1),
           number(k.k2), number(k.p1), number(k.p2), largest_r2(k), k.k1 != 0 || k.k2 != 0 || k.p1 != 0 || k.p2 != 0};
  const auto bulge = [&](int width) {
    return static_cast<float>(1 - std::cos(std::min(1.5, 0.5 * width * grid.theta_pitch)));
  };
  bulge_ = bulge(kTilePx);
  cell_bulge_ = bulge(kCellPx);
}

Window ViewFrustum::window(int column_begin, int column_end) const {
  constexpr int kSamples = 16;
  constexpr float kMargin = 0.02F;
  Window window{INFINITY, -INFINITY, INFINITY, -INFINITY};
  const auto include = [&](double x_px, double y_px) {
    const Eigen::Vector3d d = unproject(intrinsics_, {x_px, y_px});
    window.x0 = std::min(window.x0, static_cast<float>(d.x()) - kMargin);
    window.x1 = std::max(window.x1, static_cast<float>(d.x()) + kMargin);
    window.y0 = std::min(window.y0, static_cast<float>(d.y()) - kMargin);
    window.y1 = std::max(window.y1, static_cast<float>(d.y()) + kMargin);
  };
  for (int i = 0; i <= kSamples; ++i) {
    const double t = static_cast<double>(i) / kSamples;
    const double x = column_begin + t * (column_end - column_begin), y = t * intrinsics_.height;
    include(x, 0), include(x, intrinsics_.height), include(column_begin, y), include(column_end, y);
  }
  return window;
}

bool ViewFrustum::sees(const MeshTile& tile, const Window& window) const {
  const int last_column = last_column_, last_row = static_cast<int>(v_.size()) - 1;
  const size_t xs[2] = {static_cast<size_t>(tile.x0), static_cast<size_t>(std::min(tile.x0 + kTilePx, last_column))};
  const size_t ys[2] = {static_cast<size_t>(tile.y0), static_cast<size_t>(std::min(tile.y0 + kTilePx, last_row))};
  bool left = true, right = true, above = true, below = true, behind = true;
  for (const float w : {tile.w_min, tile.w_max})
    for (const size_t x : xs) {
      const float slack = bulge_ * (1 + w * b_length_[x]);
      for (const size_t y : ys) {
        const float qx = ax_[x] + v_[y] * nx_ + w * bx_[x];
        const float qy = ay_[x] + v_[y] * ny_ + w * by_[x];
        const float qz = az_[x] + v_[y] * nz_ + w * bz_[x];
        left &= qx + slack < window.x0 * qz - slack * std::abs(window.x0);
        right &= qx - slack > window.x1 * qz + slack * std::abs(window.x1);
        above &= qy + slack < window.y0 * qz - slack * std::abs(window.y0);
        below &= qy - slack > window.y1 * qz + slack * std::abs(window.y1);
        behind &= qz + slack <= 0;
      }
    }
  return !(left || right || above || below || behind);
}

// Every point of a cell is within a convex combination of its eight corners plus `slack` (q is linear in v and w, and
// the arc of theta bulges). A point moved by no more than half its q.z moves on the image by at most
// 2 slack (1 + |q.x / q.z|) / q.z.
CellBounds ViewFrustum::bounds(const MeshTile& tile) const {
  constexpr float kMarginPx = 1;  // more than rounding to 1 / kSubPx and of floats
  const auto fx = static_cast<float>(intrinsics_.fx), fy = static_cast<float>(intrinsics_.fy);
  const auto cx = static_cast<float>(intrinsics_.cx) - 0.5F, cy = static_cast<float>(intrinsics_.cy) - 0.5F;
  constexpr float kNear = 1e-6F;
  CellBounds out;
  float z_min[kCells], slack[kCells];
  for (int i = 0; i < kCells; ++i) {
    out.x0[i] = out.y0[i] = z_min[i] = INFINITY;
    out.x1[i] = out.y1[i] = -INFINITY;
  }
  const auto last_column = static_cast<size_t>(last_column_);
  const size_t last_row = v_.size() - 1;
  for (int corner = 0; corner < 4; ++corner) {
    float ax[kCells], ay[kCells], az[kCells], bx[kCells], by[kCells], bz[kCells];
    for (int i = 0; i < kCells; ++i) {
      const int column = tile.x0 + (i % kCellsAcross + (corner & 1)) * kCellPx;
      const int row = tile.y0 + (i / kCellsAcross + (corner >> 1)) * kCellPx;
      const size_t x = std::min(static_cast<size_t>(column), last_column);
      const float v = v_[std::min(static_cast<size_t>(row), last_row)];
      ax[i] = ax_[x] + v * nx_, ay[i] = ay_[x] + v * ny_, az[i] = az_[x] + v * nz_;
      bx[i] = bx_[x], by[i] = by_[x], bz[i] = bz_[x];
      slack[i] = cell_bulge_ * (1 + tile.cell_w_max[i] * b_length_[x]);
    }
    for (const float* w : {tile.cell_w_min, tile.cell_w_max})
      for (int i = 0; i < kCells; ++i) {
        const float qz = az[i] + w[i] * bz[i], scale = 1 / (qz > kNear ? qz : kNear);
        const float x = (ax[i] + w[i] * bx[i]) * scale, y = (ay[i] + w[i] * by[i]) * scale;
        const float spread = 2 * slack[i] * scale;
        const float dx = spread * (1 + std::abs(x)), dy = spread * (1 + std::abs(y));
        out.x0[i] = std::min(out.x0[i], (x - dx) * fx + (cx - kMarginPx));
        out.x1[i] = std::max(out.x1[i], (x + dx) * fx + (cx + kMarginPx));
        out.y0[i] = std::min(out.y0[i], (y - dy) * fy + (cy - kMarginPx));
        out.y1[i] = std::max(out.y1[i], (y + dy) * fy + (cy + kMarginPx));
        z_min[i] = std::min(z_min[i], qz);
      }
  }
  for (int i = 0; i < kCells; ++i) {
    constexpr float kMargin = 1.0001F;
    out.nearest[i] = kMargin * tile.cell_w_max[i] / (z_min[i] - slack[i]);
    const bool known = z_min[i] > 2 * slack[i] && z_min[i] > 0.01F;
    const bool empty = tile.cell_w_max[i] < tile.cell_w_min[i];
    if (!known) out.nearest[i] = out.x1[i] = out.y1[i] = INFINITY, out.x0[i] = out.y0[i] = -INFINITY;
    if (empty) out.x0[i] = INFINITY, out.x1[i] = -INFINITY;
  }
  return out;
}

void ViewFrustum::project_row(int x, int y, int count, const float* w, int first, ScreenRow& out) const {
  const auto column = static_cast<size_t>(x);
  const float v = v_[static_cast<size_t>(y)];
  const kernels::Rays rays = {&ax_[column], &ay_[column], &az_[column], &bx_[column], &by_[column], &bz_[column]};
  kernels_.project(rays, {v * nx_, v * ny_, v * nz_}, w, lens_, count, first, out);
}

void ViewFrustum::project_scattered(int count, const int* x, const int* y, const float* w, ScreenRow& out) const {
  float ax[kTilePx + 1], ay[kTilePx + 1], az[kTilePx + 1], bx[kTilePx + 1], by[kTilePx + 1], bz[kTilePx + 1];
  for (int i = 0; i < count; ++i) {
    const auto column = static_cast<size_t>(x[i]);
    const float v = v_[static_cast<size_t>(y[i])];
    ax[i] = ax_[column] + v * nx_;
    ay[i] = ay_[column] + v * ny_;
    az[i] = az_[column] + v * nz_;
    bx[i] = bx_[column];
    by[i] = by_[column];
    bz[i] = bz_[column];
  }
  kernels_.project({ax, ay, az, bx, by, bz}, {0, 0, 0}, w, lens_, count, 0, out);
}

}  // namespace ldp::view
