// Spherical motion: what an arm does to a camera. All cameras stand on a sphere of radius 1 around the origin and look
// outward, so that a camera's pose is its rotation alone: centre = R e_z (Ventura, ECCV 2016).
//
// Two such cameras with rotation S = R_b^T R_a see a point at x_b + e_z = S (x_a + e_z); hence translation S e_z - e_z
// and essential matrix [S e_z - e_z]x S. That is 3 unknowns instead of 5, and it holds for pure rotation too (all
// points at infinity).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ldp::sfm {

struct RayPair {
  Eigen::Vector2d a, b;  // the same point in two frames, on the plane z = 1
};

struct RelativeRotation {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  double cost = 0;  // mean of log(1 + (distance / tolerance)^2), Sampson's or of the rays
};

// The spherical motion that fits best; robust against a minority of wrong pairs. Tolerance on the plane z = 1.
RelativeRotation spherical_rotation(const std::vector<RayPair>& pairs, double tolerance);

// The rotation of a camera that does not move, which brings rays nearest to each other: robust against what is near.
RelativeRotation pure_rotation(const std::vector<RayPair>& pairs);

struct RotationEdge {
  int a = 0, b = 0;
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  double weight = 1;
};

// World-from-camera rotations that agree best with the edges (robustly: iterated least squares with Cauchy weights).
// Cameras that no edge connects with camera `first` keep the identity; `reached` tells.
std::vector<Eigen::Matrix3d> average_rotations(int count, int first, const std::vector<RotationEdge>& edges,
                                               std::vector<bool>& reached);

}  // namespace ldp::sfm
