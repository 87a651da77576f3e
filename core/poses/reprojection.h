// One observation as bundle adjustment sees it: what is left between where a point is projected and where it was seen,
// and how that changes with the camera, the lens and the point, to first order.
//
// Changes: a camera turns by a small vector in its own axes (left of camera from world) and, in the free model, its
// centre moves; lens (log focal, k1, k2); a point's direction turns along two axes across it and, but for rotations,
// its inverse distance changes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "bundle.h"

namespace ldp {

constexpr double kBeforeCamera = 1e-3;  // smallest z of a point in camera axes that is still projected

struct Distorted {
  Eigen::Vector2d position;  // focal length 1
  Eigen::Matrix2d by_undistorted;
  double squared = 0;
};

inline Distorted distort(const Eigen::Vector2d& n, double k1, double k2) {
  const double r2 = n.squaredNorm(), radial = 1 + r2 * (k1 + r2 * k2);
  return {radial * n, radial * Eigen::Matrix2d::Identity() + (2 * k1 + 4 * k2 * r2) * n * n.transpose(), r2};
}

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

struct CameraState {
  Eigen::Matrix3d camera_from_world = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // used by the free model alone
};

struct LensState {
  double log_focal = 0, k1 = 0, k2 = 0, focal_px = 1;
};

// A point and the two axes across it along which its direction turns.
struct PointState {
  InversePoint point;
  Eigen::Vector3d e1, e2;
};

template <Model kModel>
class Reprojection {
 public:
  static constexpr int kCamera = kModel == Model::free ? 6 : 3, kPoint = kModel == Model::rotation ? 2 : 3;

  // Pixels times weight. False behind the camera, where there is nothing to go by.
  bool evaluate(const CameraState& camera, const LensState& lens, const InversePoint& point,
                const BundleObservation& seen) {
    const double w = kModel == Model::rotation ? 0 : point.inverse_distance;
    turned_ = camera.camera_from_world * (kModel == Model::free ? point.seen_from(camera.centre) : point.direction);
    p_ = turned_;
    if (kModel == Model::spherical) p_.z() -= w;
    if (!(p_.z() > kBeforeCamera)) return false;
    distorted_ = distort(p_.head<2>() / p_.z(), lens.k1, lens.k2);
    residual = seen.weight * (lens.focal_px * distorted_.position - seen.position_px);
    return true;
  }

  // After evaluate of the same.
  void differentiate(const CameraState& camera, const LensState& lens, const PointState& point, double weight) {
    const Eigen::Vector2d n = p_.head<2>() / p_.z();
    const double scale = weight * lens.focal_px;
    Eigen::Matrix<double, 2, 3> n_by_p;
    n_by_p << 1 / p_.z(), 0, -n.x() / p_.z(), 0, 1 / p_.z(), -n.y() / p_.z();
    const Eigen::Matrix<double, 2, 3> by_p = scale * distorted_.by_undistorted * n_by_p;
    const Eigen::Matrix<double, 2, 3> by_world = by_p * camera.camera_from_world;
    by_camera.template leftCols<3>() = -by_p * cross_matrix(turned_);
    if constexpr (kModel == Model::free) by_camera.template rightCols<3>() = -point.point.inverse_distance * by_world;
    by_lens << scale * distorted_.position, scale * distorted_.squared * n,
        scale * distorted_.squared * distorted_.squared * n;
    by_point.col(0) = by_world * point.e1;
    by_point.col(1) = by_world * point.e2;
    if constexpr (kModel == Model::free) by_point.col(2) = -by_world * camera.centre;
    if constexpr (kModel == Model::spherical) by_point.col(2) = -by_p.col(2);
  }

  void scale(double factor) {
    residual *= factor;
    by_camera *= factor;
    by_lens *= factor;
    by_point *= factor;
  }

  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kCamera> by_camera;
  Eigen::Matrix<double, 2, 3> by_lens;
  Eigen::Matrix<double, 2, kPoint> by_point;

 private:
  Eigen::Vector3d turned_, p_;  // what a turn of the camera turns; the point in camera axes
  Distorted distorted_;
};

}  // namespace ldp
