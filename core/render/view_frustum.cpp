#include "view_frustum.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ldp::render {
namespace {

constexpr float kGuardPx = 8192;  // positions beyond this far outside the image are not kept
constexpr float kNear = 1e-6F;

// The largest squared radius up to which the radial distortion grows with the radius.
float largest_r2(const Intrinsics& k) {
  constexpr double kStep = 0.01, kLargest = 10;
  for (double r = 0; r < kLargest; r += kStep) {
    const double slope = 1 + r * r * (3 * k.k1 + 5 * k.k2 * r * r);
    if (slope <= 0.05) return static_cast<float>(r * r);
  }
  return static_cast<float>(kLargest * kLargest);
}

}  // namespace

ViewFrustum::ViewFrustum(const PanoramaGrid& grid, const Camera& camera) : intrinsics_(camera.intrinsics) {
  const Eigen::Matrix3d camera_from_world = camera.pose.world_from_camera.transpose();
  const Eigen::Vector3d n = camera_from_world * grid.arc.axis();
  nx_ = static_cast<float>(n.x()), ny_ = static_cast<float>(n.y()), nz_ = static_cast<float>(n.z());
  const size_t columns = static_cast<size_t>(grid.width) + 1;
  for (auto* table : {&ax_, &ay_, &az_, &bx_, &by_, &bz_, &b_length_}) table->resize(columns);
  for (size_t x = 0; x < columns; ++x) {
    const size_t ray = grid.wraps && x + 1 == columns ? 0 : x;
    const double theta = grid.theta(static_cast<double>(ray) + 0.5);
    const Eigen::Vector3d a = camera_from_world * grid.arc.outward(theta);
    const Eigen::Vector3d b = camera_from_world * (grid.origin(theta) - camera.pose.centre);
    ax_[x] = static_cast<float>(a.x()), ay_[x] = static_cast<float>(a.y()), az_[x] = static_cast<float>(a.z());
    bx_[x] = static_cast<float>(b.x()), by_[x] = static_cast<float>(b.y()), bz_[x] = static_cast<float>(b.z());
    b_length_[x] = static_cast<float>(b.norm());
  }
  for (int y = 0; y < grid.height; ++y) v_.push_back(static_cast<float>(grid.v(y + 0.5)));
  const Intrinsics& k = intrinsics_;
  distorted_ = k.k1 != 0 || k.k2 != 0 || k.p1 != 0 || k.p2 != 0;
  max_r2_ = largest_r2(k);
  bulge_ = static_cast<float>(1 - std::cos(std::min(1.5, 0.5 * kTilePx * grid.theta_pitch)));
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
  const int last_column = static_cast<int>(ax_.size()) - 1, last_row = static_cast<int>(v_.size()) - 1;
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

void ViewFrustum::project_row(int x, int y, int count, const float* w, ScreenRow& out) const {
  const size_t begin = static_cast<size_t>(x);
  const float v = v_[static_cast<size_t>(y)];
  const float vx = v * nx_, vy = v * ny_, vz = v * nz_;
  Lanes base;
  for (int i = 0; i < count; ++i) {
    const size_t column = begin + static_cast<size_t>(i);
    base.base_x[i] = ax_[column] + vx;
    base.base_y[i] = ay_[column] + vy;
    base.base_z[i] = az_[column] + vz;
  }
  project(count, base, &bx_[begin], &by_[begin], &bz_[begin], w, out);
}

void ViewFrustum::project_scattered(int count, const int* x, const int* y, const float* w, ScreenRow& out) const {
  Lanes base, slope;
  for (int i = 0; i < count; ++i) {
    const auto column = static_cast<size_t>(x[i]);
    const float v = v_[static_cast<size_t>(y[i])];
    base.base_x[i] = ax_[column] + v * nx_;
    base.base_y[i] = ay_[column] + v * ny_;
    base.base_z[i] = az_[column] + v * nz_;
    slope.base_x[i] = bx_[column];
    slope.base_y[i] = by_[column];
    slope.base_z[i] = bz_[column];
  }
  project(count, base, slope.base_x, slope.base_y, slope.base_z, w, out);
}

void ViewFrustum::project(int count, const Lanes& base, const float* bx, const float* by, const float* bz,
                          const float* w, ScreenRow& out) const {
  float px[kTilePx + 1], py[kTilePx + 1], in_front[kTilePx + 1];
  for (int i = 0; i < count; ++i) {
    const float qx = base.base_x[i] + w[i] * bx[i];
    const float qy = base.base_y[i] + w[i] * by[i];
    const float qz = base.base_z[i] + w[i] * bz[i];
    const float scale = 1 / (qz > kNear ? qz : kNear);
    px[i] = qx * scale;
    py[i] = qy * scale;
    in_front[i] = qz;
    out.inverse_z[i] = w[i] * scale;
  }
  if (distorted_) distort(count, px, py, in_front);
  to_screen(count, px, py, in_front, out);
}

// Positions beyond the distortion's range are put behind the camera.
void ViewFrustum::distort(int count, float* __restrict x, float* __restrict y, float* __restrict in_front) const {
  const auto k1 = static_cast<float>(intrinsics_.k1), k2 = static_cast<float>(intrinsics_.k2);
  const auto p1 = static_cast<float>(intrinsics_.p1), p2 = static_cast<float>(intrinsics_.p2);
  const float max_r2 = max_r2_;
  for (int i = 0; i < count; ++i) {
    const float r2 = x[i] * x[i] + y[i] * y[i], xy = x[i] * y[i];
    const float radial = 1 + r2 * (k1 + r2 * k2);
    const float dx = x[i] * radial + 2 * p1 * xy + p2 * (r2 + 2 * x[i] * x[i]);
    const float dy = y[i] * radial + p1 * (r2 + 2 * y[i] * y[i]) + 2 * p2 * xy;
    in_front[i] = r2 < max_r2 ? in_front[i] : -1.0F;
    x[i] = dx;
    y[i] = dy;
  }
}

void ViewFrustum::to_screen(int count, const float* nx, const float* ny, const float* in_front, ScreenRow& out) const {
  const auto fx = static_cast<float>(intrinsics_.fx), fy = static_cast<float>(intrinsics_.fy);
  const auto cx = static_cast<float>(intrinsics_.cx), cy = static_cast<float>(intrinsics_.cy);
  int32_t* __restrict out_x = out.x;
  int32_t* __restrict out_y = out.y;
  for (int i = 0; i < count; ++i) {
    // Pixel centres become integers; the offset makes the conversion, which cuts towards zero, round.
    const float x = nx[i] * fx + cx + (kGuardPx - 0.5F), y = ny[i] * fy + cy + (kGuardPx - 0.5F);
    // Not short-circuited, so that the loop vectorises.
    const bool ok = (in_front[i] > kNear) & (x > 0) & (y > 0) & (x < 4 * kGuardPx) & (y < 4 * kGuardPx);
    constexpr auto kShift = static_cast<int32_t>(kGuardPx) * kSubPx;
    const float safe_x = ok ? x : 0.0F, safe_y = ok ? y : 0.0F;
    const int32_t ix = static_cast<int32_t>(safe_x * kSubPx + 0.5F) - kShift;
    const int32_t iy = static_cast<int32_t>(safe_y * kSubPx + 0.5F) - kShift;
    out_x[i] = ok ? ix : kOffScreen;
    out_y[i] = iy;
  }
}

}  // namespace ldp::render
