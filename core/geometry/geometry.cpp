#include "core/geometry/geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ldp {

Eigen::Vector2d distort_beyond_end(const Intrinsics& k, const Eigen::Vector2d& n) {
  const double root = std::sqrt(std::max(0.0, 9 * k.k1 * k.k1 - 20 * k.k2));
  const double end_r2 = 2 / (root - 3 * k.k1);  // the lesser root of the slope
  const Eigen::Vector2d end = n * std::sqrt(end_r2 / n.squaredNorm());
  return distort_by_polynomial(k, end) + (n - end);
}

Eigen::Vector3d unproject(const Intrinsics& intrinsics, const Eigen::Vector2d& position_px) {
  const Eigen::Vector2d distorted((position_px.x() - intrinsics.cx) / intrinsics.fx,
                                  (position_px.y() - intrinsics.cy) / intrinsics.fy);
  Eigen::Vector2d n = distorted;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d residual = distort_by_polynomial(intrinsics, n) - distorted;
    n -= residual;
    if (residual.squaredNorm() < 1e-20) break;
  }
  return {n.x(), n.y(), 1};
}

Eigen::Vector3d Arc::outward(double theta) const {
  return std::cos(theta) * world_from_arc.col(0) + std::sin(theta) * world_from_arc.col(1);
}

Eigen::Vector3d PanoramaGrid::origin(double theta) const { return arc.centre + ray_radius() * arc.outward(theta); }

Eigen::Vector3d PanoramaGrid::direction(double theta, double v) const { return arc.outward(theta) + v * arc.axis(); }

Eigen::Vector3d PanoramaGrid::point(double theta, double v, double w) const {
  return origin(theta) + direction(theta, v) / w;
}

PanoramaPosition locate(const PanoramaGrid& grid, const Eigen::Vector3d& point_in_world) {
  const Eigen::Vector3d p = grid.arc.world_from_arc.transpose() * (point_in_world - grid.arc.centre);
  const double depth = std::hypot(p.x(), p.y()) - grid.ray_radius();
  const double turn = 2 * std::numbers::pi;
  double right = grid.theta_left - std::atan2(p.y(), p.x());
  right -= turn * std::floor(right / turn);
  return {right / grid.theta_pitch, (grid.v_top - p.z() / depth) / grid.v_pitch, 1 / depth};
}

}  // namespace ldp
