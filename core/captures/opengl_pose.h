// Poses as other programs write them (transforms.json, OpenGL): camera-to-world 4x4, camera axes x right, y up, z back.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/geometry.h"

namespace ldp {

// None where the matrix is not finite, or its columns are not unit, orthogonal and right-handed to three digits.
// Numbers written with few digits become a rotation again.
std::optional<Pose> pose_of_opengl(const Eigen::Matrix4d& world_from_camera);

Eigen::Matrix4d opengl_matrix(const Pose& pose);

}  // namespace ldp
