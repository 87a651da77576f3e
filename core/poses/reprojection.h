// Where a point appears in a camera, with derivatives: the one equation of bundle adjustment.
//
// Rotations take camera from world and are turned from the left by small vectors; focal lengths are logarithms; a
// point's direction is base + a e1 + b e2, around where it was at the start.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "bundle.h"

namespace ldp {

constexpr double kNearest = 1e-3;   // smallest z of a point in camera axes that is still projected
constexpr double kLongestLog = 14;  // of a focal length in pixels: beyond, a step went astray
constexpr double kBehind_px = 1e3;  // residual of a point behind the camera
constexpr int kLensSize = 3;        // log focal, k1, k2
constexpr int kPointSize = 3;       // a, b, inverse distance

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

struct DirectionFrame {
  Eigen::Vector3d base, e1, e2;
};

struct Distorted {
  Eigen::Vector2d position;  // focal length 1
  Eigen::Matrix2d by_undistorted;
  double squared = 0;
};

inline Distorted distort(const Eigen::Vector2d& n, double k1, double k2) {
  const double r2 = n.squaredNorm(), radial = 1 + r2 * (k1 + r2 * k2);
  return {radial * n, radial * Eigen::Matrix2d::Identity() + (2 * k1 + 4 * k2 * r2) * n * n.transpose(), r2};
}

// Size of a camera's unknowns: a turn, and where its centre moves, if free.
constexpr int camera_size(Model model) { return model == Model::free ? 6 : 3; }

struct FreeCamera {
  Eigen::Matrix3d rotation;  // camera from world
  Eigen::Vector3d centre;    // of use where the model is free
};

// What a turn of the camera turns, and the point in camera axes.
struct Seen {
  Eigen::Vector3d turned, p;
  bool in_front = false;
};

template <Model kModel>
Seen see(const FreeCamera& camera, const Eigen::Vector3d& lens, const DirectionFrame& frame,
         const Eigen::Vector3d& point) {
  Seen seen;
  Eigen::Vector3d m = frame.base + point[0] * frame.e1 + point[1] * frame.e2;
  if constexpr (kModel == Model::free) m -= point[2] * camera.centre;
  seen.turned = camera.rotation * m;
  seen.p = seen.turned;
  if constexpr (kModel == Model::spherical) seen.p.z() -= point[2];
  seen.in_front = seen.p.z() > kNearest && std::abs(lens[0]) < kLongestLog;
  return seen;
}

// Weighted residual of a point in front of the camera.
inline Eigen::Vector2d residual(const Seen& seen, const Eigen::Vector3d& lens, const BundleObservation& o) {
  const Eigen::Vector2d n = seen.p.head<2>() / seen.p.z();
  const double r2 = n.squaredNorm(), radial = 1 + r2 * (lens[1] + r2 * lens[2]);
  return o.weight * (std::exp(lens[0]) * radial * n - o.position_px);
}

template <Model kModel>
struct Derivatives {
  Eigen::Matrix<double, 2, camera_size(kModel)> by_camera;
  Eigen::Matrix<double, 2, kLensSize> by_lens;
  Eigen::Matrix<double, 2, kPointSize> by_point;
};

template <Model kModel>
Derivatives<kModel> derivatives(const FreeCamera& camera, const Eigen::Vector3d& lens, const DirectionFrame& frame,
                                const Eigen::Vector3d& point, const Seen& seen, double weight) {
  const Eigen::Vector2d n = seen.p.head<2>() / seen.p.z();
  const Distorted d = distort(n, lens[1], lens[2]);
  const double focal = weight * std::exp(lens[0]);
  Eigen::Matrix<double, 2, 3> n_by_p;
  n_by_p << 1 / seen.p.z(), 0, -n.x() / seen.p.z(), 0, 1 / seen.p.z(), -n.y() / seen.p.z();
  const Eigen::Matrix<double, 2, 3> by_p = focal * d.by_undistorted * n_by_p;
  const Eigen::Matrix<double, 2, 3> by_m = by_p * camera.rotation;

  Derivatives<kModel> by;
  by.by_camera.template leftCols<3>() = -by_p * cross_matrix(seen.turned);
  if constexpr (kModel == Model::free) by.by_camera.template rightCols<3>() = -point[2] * by_m;
  by.by_lens.col(0) = focal * d.position;
  by.by_lens.col(1) = focal * d.squared * n;
  by.by_lens.col(2) = focal * d.squared * d.squared * n;
  by.by_point.col(0) = by_m * frame.e1;
  by.by_point.col(1) = by_m * frame.e2;
  if constexpr (kModel == Model::rotation) by.by_point.col(2).setZero();
  if constexpr (kModel == Model::spherical) by.by_point.col(2) = -by_p.col(2);
  if constexpr (kModel == Model::free) by.by_point.col(2) = -by_m * camera.centre;
  return by;
}

}  // namespace ldp
