// A sweep's cameras, one lens for all of them, and points of inverse distance with where they are seen: what bundle
// adjustment works on.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/poses/tracks/track_tuning.h"
#include "core/poses/tracks/tracks.h"
#include "core/poses/tracks/triangulation.h"

namespace ldp::sfm {

struct Lens {
  double focal_px = 0, k1 = 0, k2 = 0;
};

struct BundleObservation {
  int camera = 0, point = 0;
  Eigen::Vector2d position_px = Eigen::Vector2d::Zero();  // from the principal point
  double weight = 1;                                      // of the residual: inverse deviation
};

struct Bundle {
  std::vector<Pose> cameras;
  Lens lens;
  std::vector<InversePoint> points;  // distances from the origin
  std::vector<BundleObservation> observations;
};

// Image position relative to the principal point, and whether the point lies in front of the camera.
struct Projection {
  Eigen::Vector2d position_px = Eigen::Vector2d::Zero();
  bool in_front = false;
};
// Position undistorted to the plane z = 1.
Eigen::Vector2d undistorted_ray(const Eigen::Vector2d& position_px, const Lens& lens);

Projection project_point(const Pose& camera, const Lens& lens, const InversePoint& point);

struct Distorted {
  Eigen::Vector2d position;  // focal length 1
  Eigen::Matrix2d by_undistorted;
  double squared = 0;
};

inline Distorted distort(const Eigen::Vector2d& n, double k1, double k2) {
  const double r2 = n.squaredNorm(), radial = 1 + r2 * (k1 + r2 * k2);
  return {radial * n, radial * Eigen::Matrix2d::Identity() + (2 * k1 + 4 * k2 * r2) * n * n.transpose(), r2};
}

void add_point(const Track& track, const InversePoint& point, Bundle& bundle);

}  // namespace ldp::sfm
