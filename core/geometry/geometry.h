// Every geometric convention of the project, once.
//
// World: right-handed. Camera axes (OpenCV): x right, y down, z forward into the scene. Transforms are named by their
// ends: world_from_camera * x_in_camera = x_in_world. Angles are radians, lengths are the capture's own unit (metres
// when poses are estimated), image positions are pixels with pixel centres at .5 (see plane.h).
//
// The arc (paper 3.1) has centre C, unit axis n (up) and radius r. u(theta) is the outward horizontal unit vector at
// angle theta, growing anticlockwise seen from above. A panorama ray (theta, v)
//   pushbroom: starts at C + r u(theta), a point at depth d being C + (r + d) u(theta) + d v n
//   central:   the same with r = 0.
// d is the distance between concentric cylinders, w = 1/d the inverse depth, v the height at unit depth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/disparity.h"

namespace ldp {

// Pinhole with radial and tangential distortion in OpenCV's order; principal point with pixel centres at .5, so that
// the middle of a w-pixel wide image is w/2.
struct Intrinsics {
  int width = 0, height = 0;              // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;  // Brown-Conrady, on normalised coordinates
};

// World-from-camera rotation (columns: the camera's right, down and forward axes in the world) and camera centre.
struct Pose {
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

struct Camera {
  std::string name;  // the photo's file name without folders
  Intrinsics intrinsics;
  Pose pose;
};

// The lens model's polynomial, of a position at z = 1.
inline Eigen::Vector2d distort_by_polynomial(const Intrinsics& k, const Eigen::Vector2d& n) {
  const double r2 = n.squaredNorm();
  const double radial = 1 + r2 * (k.k1 + r2 * k.k2);
  const double xy = n.x() * n.y();
  return {n.x() * radial + 2 * k.p1 * xy + k.p2 * (r2 + 2 * n.x() * n.x()),
          n.y() * radial + k.p1 * (r2 + 2 * n.y() * n.y()) + 2 * k.p2 * xy};
}

// Whether it leads ever farther out from the middle to that squared radius. Where that ends it turns back: what lies
// far outside the picture would fall into it.
inline bool leads_outward(const Intrinsics& k, double r2) {
  const double slope = 1 + r2 * (3 * k.k1 + 5 * r2 * k.k2);
  const bool one_end = k.k1 >= 0 || k.k2 <= 0 || 9 * k.k1 * k.k1 < 20 * k.k2;  // or none
  return slope > 0 && (one_end || 10 * k.k2 * r2 < -3 * k.k1);
}

// Of a position beyond that end: where the end lies, and on by as far as the position is beyond it.
Eigen::Vector2d distort_beyond_end(const Intrinsics& k, const Eigen::Vector2d& n);

// Of a position at z = 1.
inline Eigen::Vector2d distort(const Intrinsics& k, const Eigen::Vector2d& n) {
  if (k.k1 == 0 && k.k2 == 0 && k.p1 == 0 && k.p2 == 0) return n;
  return leads_outward(k, n.squaredNorm()) ? distort_by_polynomial(k, n) : distort_beyond_end(k, n);
}

// Position in the image of a point given in camera axes (z > 0 required), distortion included.
inline Eigen::Vector2d project(const Intrinsics& intrinsics, const Eigen::Vector3d& x_in_camera) {
  const Eigen::Vector2d d = distort(intrinsics, x_in_camera.head<2>() / x_in_camera.z());
  return {intrinsics.fx * d.x() + intrinsics.cx, intrinsics.fy * d.y() + intrinsics.cy};
}

// Viewing direction in camera axes (z = 1) of an image position; the distortion's polynomial is inverted
// iteratively to 1e-9. Of positions that it does not reach, beyond where it ends to lead outward, nothing is known.
Eigen::Vector3d unproject(const Intrinsics& intrinsics, const Eigen::Vector2d& position_px);

// A point reconstructed by structure from motion and the cameras (indices into the camera list) that see it.
struct ScenePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<int> cameras;
};

// The circle on which the hand moved.
struct Arc {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d world_from_arc = Eigen::Matrix3d::Identity();  // columns: u(0), u(pi/2), n
  double radius = 0;
  double theta_begin = 0, theta_end = 0;  // hand's path, theta_begin < theta_end, unwrapped; 2 pi apart when closed
  bool closed = false;                    // the sweep comes back to its start

  Eigen::Vector3d axis() const { return world_from_arc.col(2); }
  Eigen::Vector3d outward(double theta) const;  // u(theta) in the world
};

enum class Rays : uint8_t { pushbroom = 0, central = 1 };

// The sampling of (theta, v) by pixels, and of inverse depth by labels. Column x looks along
// theta(x) = theta_left - (x + 0.5) theta_pitch (so that the panorama is not mirrored: columns run clockwise),
// row y has v(y) = v_top - (y + 0.5) v_pitch.
struct PanoramaGrid {
  Arc arc;
  Rays rays = Rays::pushbroom;
  int width = 0, height = 0;
  double theta_left = 0, theta_pitch = 0;  // theta_pitch * width = 2 pi exactly when the panorama wraps
  double v_top = 0, v_pitch = 0;
  bool wraps = false;            // column width is column 0 again
  double w_far = 0, w_near = 0;  // inverse depths of label 0 and of the last label; w_far may be 0

  double ray_radius() const { return rays == Rays::pushbroom ? arc.radius : 0.0; }
  double theta(double x_px) const {
    return theta_left - x_px * theta_pitch;
  }  // x_px continuous: centre of column x at x + .5
  double v(double y_px) const { return v_top - y_px * v_pitch; }
  double inverse_depth(double disparity) const {  // disparity in steps (0 .. kDisparitySteps), see disparity.h
    return w_far + (w_near - w_far) * disparity / kDisparitySteps;
  }

  // World point of a ray at inverse depth w. With w = 0 the point is at infinity: only `direction` is defined.
  Eigen::Vector3d point(double theta, double v, double w) const;
  Eigen::Vector3d origin(double theta) const;
  Eigen::Vector3d direction(double theta, double v) const;  // u(theta) + v n, not normalised
};

// Where a world point lies in the panorama: continuous column (unwrapped into [0, 2 pi / theta_pitch) from
// theta_left), continuous row and inverse depth. Points nearer to the axis than the ray origins get inverse_depth < 0.
struct PanoramaPosition {
  double x_px = 0, y_px = 0, inverse_depth = 0;
};
PanoramaPosition locate(const PanoramaGrid& grid, const Eigen::Vector3d& point_in_world);

}  // namespace ldp
