// Where an upright camera sees a voxel (theta, v, w) of the panorama, for the many voxels of one column.
//
// Equations (1), with p = C + R u + d (u + v n), d = 1/w, R the ray radius, a = C - c, multiplied through by w so that
// infinity is an ordinary voxel:
//   right   = w a.r + (R w + 1) u.r      x = focal right / forward + cx
//   forward = w a.f + (R w + 1) u.f      y = focal down  / forward + cy
//   down    = -(w a.n + v)               1 / (q.f) = w / forward
// Sines, axes and offsets are rounded to 2^-30; everything after them is plain IEEE arithmetic. So libm and fused
// multiply-adds inside Eigen do not show: the same bits on every machine.
#pragma once

#include <cmath>

#include "core/geometry/geometry.h"
#include "core/geometry/upright_camera.h"

namespace ldp {

inline double snapped(double value) {
  constexpr double kSteps = 1 << 30;
  return std::nearbyint(value * kSteps) / kSteps;
}

// cos and sin of an angle in the arc's plane.
struct Heading {
  double cos = 0, sin = 0;
};

inline Heading heading(double theta) { return {snapped(std::cos(theta)), snapped(std::sin(theta))}; }

class VoxelProjection {
 public:
  struct Column {  // u(theta) in the camera's axes
    double right = 0, forward = 0;
  };

  VoxelProjection(const PanoramaGrid& grid, const UprightCamera& camera)
      : focal_(camera.focal), cx_(camera.cx), cy_(camera.cy), ray_radius_(grid.ray_radius()) {
    const Eigen::Matrix3d arc_from_world = grid.arc.world_from_arc.transpose();
    const Eigen::Vector3d right = arc_from_world * camera.right, forward = arc_from_world * camera.forward;
    const Eigen::Vector3d a = arc_from_world * (grid.arc.centre - camera.centre);
    right_x_ = snapped(right.x()), right_y_ = snapped(right.y());
    forward_x_ = snapped(forward.x()), forward_y_ = snapped(forward.y());
    a_right_ = snapped(a.dot(right)), a_forward_ = snapped(a.dot(forward)), a_up_ = snapped(a.z());
    place_x_ = -snapped(a.x()), place_y_ = -snapped(a.y());
  }

  Column column(Heading u) const {
    return {u.cos * right_x_ + u.sin * right_y_, u.cos * forward_x_ + u.sin * forward_y_};
  }

  // Distance along `forward`, times w. The voxel is in front of the camera when it is positive.
  double forward(Column u, double w) const { return w * a_forward_ + (ray_radius_ * w + 1) * u.forward; }
  double right(Column u, double w) const { return w * a_right_ + (ray_radius_ * w + 1) * u.right; }
  double up(double v, double w) const { return w * a_up_ + v; }
  // Distance of the camera from the vertical plane through the arc's axis along u, signed.
  double aside(Heading u) const { return u.cos * place_y_ - u.sin * place_x_; }
  double x_px(Column u, double w) const { return focal_ * right(u, w) / forward(u, w) + cx_; }

  // y = row_at(v = 0) + v * row_slope for every v of one (theta, w).
  double row_slope(double forward_times_w) const { return -focal_ / forward_times_w; }
  double row_offset(double w, double forward_times_w) const { return -focal_ * w * a_up_ / forward_times_w + cy_; }

 private:
  double focal_, cx_, cy_, ray_radius_;
  double right_x_, right_y_, forward_x_, forward_y_;
  double a_right_, a_forward_, a_up_;
  double place_x_, place_y_;  // of the camera, seen from the arc's centre
};

}  // namespace ldp
