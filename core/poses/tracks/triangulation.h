// Triangulation of points.
//
// Points are homogeneous, (m, w) with unit direction m and inverse distance w from an origin near the cameras: the
// point is origin + m / w, and a point at infinity is simply w = 0. Seen from a centre c
// (relative to the origin) it lies in direction m - w c.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ldp::sfm {

struct InversePoint {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double inverse_distance = 0;

  Eigen::Vector3d seen_from(const Eigen::Vector3d& centre) const { return direction - inverse_distance * centre; }
};

// A line of sight for triangulation: where it starts (relative to the origin), the camera, and the undistorted image
// position it goes through, on the plane z = 1.
struct Sighting {
  Eigen::Matrix3d camera_from_world = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
};

// Distance on the plane z = 1 between where a point is seen and where it should be; infinite behind the camera.
double normalised_error(const InversePoint& point, const Sighting& sighting);

// Least squares over all sightings (at least two). None when they leave the point behind a camera.
std::optional<InversePoint> triangulate_point(const std::vector<Sighting>& sightings);

// The same, leaving out sightings that are farther than `tolerance` from the point, the worst first; `used` tells which
// were kept. None when fewer than two agree.
std::optional<InversePoint> triangulate_point_robustly(const std::vector<Sighting>& sightings, double tolerance,
                                                       std::vector<bool>& used);

}  // namespace ldp::sfm
