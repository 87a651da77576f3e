// Where a camera sees a voxel (theta, v, w) of the panorama, for many voxels: every stage's one projection.
//
// Equations (1), with p = C + R u + d (u + v n), d = 1/w, R the ray radius, c the camera's centre, a = C - c,
// multiplied through by w so that infinity is an ordinary voxel. Along any axis e of the camera
//   w (p - c) . e = w a.e + (R w + 1) u.e + v n.e
// An upright camera's axes are right, forward and -n:
//   right   = w a.r + (R w + 1) u.r      x = focal right / forward + cx
//   forward = w a.f + (R w + 1) u.f      y = focal down  / forward + cy
//   down    = -(w a.n + v)               1 / (q.f) = w / forward
// Sines, axes and offsets come from plain IEEE arithmetic, as does everything after them: the same bits on every
// machine.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/exact_math.h"
#include "core/geometry/geometry.h"
#include "core/geometry/upright_camera.h"

namespace ldp {

constexpr double kLeastForward = 0.1;  // times w: what is nearer to a camera than that is not looked for in its photo

// How sines, axes and offsets are kept.
enum class Rounding : uint8_t { none, snapped };  // snapped: to 2^-30

inline double kept(double value, Rounding rounding) {
  constexpr double kSteps = 1 << 30;
  return rounding == Rounding::snapped ? std::nearbyint(value * kSteps) / kSteps : value;
}

// cos and sin of an angle in the arc's plane.
struct Heading {
  double cos = 0, sin = 0;
};

inline Heading heading(double theta, Rounding rounding = Rounding::snapped) {
  const SineCosine angle = exact_sine_cosine(theta);
  return {kept(angle.cosine, rounding), kept(angle.sine, rounding)};
}

// One axis e of a camera.
struct CameraAxis {
  double x = 0, y = 0, up = 0;  // in the arc's axes
  double offset = 0;            // a.e

  CameraAxis() = default;
  CameraAxis(const Arc& arc, const Eigen::Vector3d& camera_centre, const Eigen::Vector3d& axis, Rounding rounding)
      : x(kept(exact_dot(axis, arc.world_from_arc.col(0)), rounding)),
        y(kept(exact_dot(axis, arc.world_from_arc.col(1)), rounding)),
        up(kept(exact_dot(axis, arc.world_from_arc.col(2)), rounding)),
        offset(kept(exact_dot(arc.centre - camera_centre, axis), rounding)) {}

  double of(Heading u) const { return u.cos * x + u.sin * y; }  // u.e
  // Along the axis, times w; reach = R w + 1. Of a horizontal axis, and of any.
  double along(double of_heading, double reach, double w) const { return w * offset + reach * of_heading; }
  double along(double of_heading, double reach, double v, double w) const {
    return along(of_heading, reach, w) + v * up;
  }
};

// Into an upright camera.
class VoxelProjection {
 public:
  struct Column {  // u(theta) in the camera's axes
    double right = 0, forward = 0;
  };

  VoxelProjection(const PanoramaGrid& grid, const UprightCamera& camera, Rounding rounding = Rounding::snapped)
      : focal_(camera.focal),
        cx_(camera.cx),
        cy_(camera.cy),
        ray_radius_(grid.ray_radius()),
        right_(grid.arc, camera.centre, camera.right, rounding),
        forward_(grid.arc, camera.centre, camera.forward, rounding),
        a_up_(kept(exact_dot(grid.arc.centre - camera.centre, grid.arc.axis()), rounding)) {
    const Eigen::Vector3d a = grid.arc.centre - camera.centre;
    place_x_ = -kept(exact_dot(a, grid.arc.world_from_arc.col(0)), rounding);
    place_y_ = -kept(exact_dot(a, grid.arc.world_from_arc.col(1)), rounding);
  }

  Column column(Heading u) const { return {right_.of(u), forward_.of(u)}; }

  // Distance along `forward`, times w. The voxel is in front of the camera when it is positive.
  double forward(Column u, double w) const { return forward_.along(u.forward, ray_radius_ * w + 1, w); }
  double right(Column u, double w) const { return right_.along(u.right, ray_radius_ * w + 1, w); }
  double up(double v, double w) const { return w * a_up_ + v; }
  // Distance of the camera from the vertical plane through the arc's axis along u, signed.
  double aside(Heading u) const { return u.cos * place_y_ - u.sin * place_x_; }
  double x_px(Column u, double w) const { return focal_ * right(u, w) / forward(u, w) + cx_; }

  // y = row_at(v = 0) + v * row_slope for every v of one (theta, w).
  double row_slope(double forward_times_w) const { return -focal_ / forward_times_w; }
  double row_offset(double w, double forward_times_w) const { return -focal_ * w * a_up_ / forward_times_w + cy_; }

 private:
  double focal_, cx_, cy_, ray_radius_;
  CameraAxis right_, forward_;
  double a_up_;
  double place_x_, place_y_;  // of the camera, seen from the arc's centre
};

// Into a photograph as it was taken, distortion included (`project` of what lies in front).
class PhotoProjection {
 public:
  PhotoProjection(const PanoramaGrid& grid, const Camera& camera) : ray_radius_(grid.ray_radius()) {
    for (size_t i = 0; i < 3; ++i)
      axes_[i] = {grid.arc, camera.pose.centre, camera.pose.world_from_camera.col(static_cast<Eigen::Index>(i)),
                  Rounding::snapped};
  }

  using Column = std::array<double, 3>;  // u(theta) in the camera's axes

  Column column(Heading u) const { return {axes_[0].of(u), axes_[1].of(u), axes_[2].of(u)}; }

  // The voxel in camera axes, times w: a direction at infinity.
  Eigen::Vector3d in_camera_axes(const Column& u, double v, double w) const {
    const double reach = ray_radius_ * w + 1;
    const auto along = [&](size_t i) { return axes_[i].along(u[i], reach, v, w); };
    return {along(0), along(1), along(2)};
  }
  Eigen::Vector3d in_camera_axes(Heading u, double v, double w) const { return in_camera_axes(column(u), v, w); }

 private:
  double ray_radius_;
  std::array<CameraAxis, 3> axes_;  // right, down, forward
};

}  // namespace ldp
