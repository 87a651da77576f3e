#include "core/captures/opengl_pose.h"

#include <Eigen/LU>

#include "core/base/exact_math.h"

namespace ldp {
namespace {

// OpenGL's camera axes (right, up, back) against ours (right, down, forward).
const Eigen::Vector3d kOpenGlFromOurs(1, -1, -1);

}  // namespace

std::optional<Pose> pose_of_opengl(const Eigen::Matrix4d& matrix) {
  if (!matrix.allFinite()) return std::nullopt;
  Pose pose;
  pose.world_from_camera = matrix.topLeftCorner<3, 3>() * kOpenGlFromOurs.asDiagonal();
  pose.centre = matrix.topRightCorner<3, 1>();
  const double skew =
      (pose.world_from_camera.transpose() * pose.world_from_camera - Eigen::Matrix3d::Identity()).norm();
  if (skew > 1e-3 || pose.world_from_camera.determinant() < 0) return std::nullopt;
  // Back to a rotation, by the iteration R (3 I - R'R) / 2, which converges squared.
  for (int i = 0; i < 4 && skew > 1e-12; ++i) {
    const Eigen::Matrix3d r = pose.world_from_camera;
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d column = 3 * Eigen::Matrix3d::Identity().col(j) - exact_transposed_product(r, r.col(j));
      pose.world_from_camera.col(j) = 0.5 * exact_product(r, column);
    }
  }
  return pose;
}

Eigen::Matrix4d opengl_matrix(const Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.world_from_camera * kOpenGlFromOurs.asDiagonal();
  matrix.topRightCorner<3, 1>() = pose.centre;
  return matrix;
}

}  // namespace ldp
