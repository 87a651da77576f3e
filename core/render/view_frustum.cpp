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
  for (auto* table : {&ax_, &ay_, &az_, &bx_, &by_, &bz_}) table->resize(columns);
  for (size_t x = 0; x < columns; ++x) {
    const size_t ray = grid.wraps && x + 1 == columns ? 0 : x;
    const double theta = grid.theta(static_cast<double>(ray) + 0.5);
    const Eigen::Vector3d a = camera_from_world * grid.arc.outward(theta);
    const Eigen::Vector3d b = camera_from_world * (grid.origin(theta) - camera.pose.centre);
    ax_[x] = static_cast<float>(a.x()), ay_[x] = static_cast<float>(a.y()), az_[x] = static_cast<float>(a.z());
    bx_[x] = static_cast<float>(b.x()), by_[x] = static_cast<float>(b.y()), bz_[x] = static_cast<float>(b.z());
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
      const float reach = 1 + w * std::abs(std::hypot(bx_[x], by_[x], bz_[x]));
      const float slack = bulge_ * reach;
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
  const float *ax = &ax_[begin], *ay = &ay_[begin], *az = &az_[begin];
  const float *bx = &bx_[begin], *by = &by_[begin], *bz = &bz_[begin];
  const float v = v_[static_cast<size_t>(y)];
  const float vx = v * nx_, vy = v * ny_, vz = v * nz_;
  float px[kTilePx + 1], py[kTilePx + 1], in_front[kTilePx + 1];
  for (int i = 0; i < count; ++i) {
    const float qx = (ax[i] + vx) + w[i] * bx[i];
    const float qy = (ay[i] + vy) + w[i] * by[i];
    const float qz = (az[i] + vz) + w[i] * bz[i];
    const float scale = 1 / (qz > kNear ? qz : kNear);
    px[i] = qx * scale;
    py[i] = qy * scale;
    in_front[i] = qz;
    out.inverse_z[i] = w[i] * scale;
  }
  to_screen(count, px, py, in_front, out);
}

void ViewFrustum::project(int x, int y, float w, int32_t& out_x, int32_t& out_y, float& out_inverse_z) const {
  ScreenRow row;
  project_row(x, y, 1, &w, row);
  out_x = row.x[0], out_y = row.y[0], out_inverse_z = row.inverse_z[0];
}

void ViewFrustum::to_screen(int count, const float* nx, const float* ny, const float* in_front, ScreenRow& out) const {
  const auto fx = static_cast<float>(intrinsics_.fx), fy = static_cast<float>(intrinsics_.fy);
  const auto cx = static_cast<float>(intrinsics_.cx), cy = static_cast<float>(intrinsics_.cy);
  const auto k1 = static_cast<float>(intrinsics_.k1), k2 = static_cast<float>(intrinsics_.k2);
  const auto p1 = static_cast<float>(intrinsics_.p1), p2 = static_cast<float>(intrinsics_.p2);
  const float max_r2 = distorted_ ? max_r2_ : INFINITY;
  for (int i = 0; i < count; ++i) {
    float dx = nx[i], dy = ny[i];
    const float r2 = dx * dx + dy * dy;
    if (distorted_) {
      const float radial = 1 + r2 * (k1 + r2 * k2), xy = dx * dy;
      const float tx = dx * radial + 2 * p1 * xy + p2 * (r2 + 2 * dx * dx);
      dy = dy * radial + p1 * (r2 + 2 * dy * dy) + 2 * p2 * xy;
      dx = tx;
    }
    // Pixel centres become integers; the offset makes the conversion, which cuts towards zero, round.
    const float x = dx * fx + cx + (kGuardPx - 0.5F), y = dy * fy + cy + (kGuardPx - 0.5F);
    const bool ok = in_front[i] > kNear && r2 < max_r2 && x > 0 && y > 0 && x < 4 * kGuardPx && y < 4 * kGuardPx;
    constexpr auto kShift = static_cast<int32_t>(kGuardPx) * kSubPx;
    const float safe_x = ok ? x : 0, safe_y = ok ? y : 0;
    const int32_t ix = static_cast<int32_t>(safe_x * kSubPx + 0.5F) - kShift;
    const int32_t iy = static_cast<int32_t>(safe_y * kSubPx + 0.5F) - kShift;
    out.x[i] = ok ? ix : kOffScreen;
    out.y[i] = iy;
  }
}

}  // namespace ldp::render
