// The solids and leaves that a scene is made of: where a ray meets one.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "sim/scene/scene.h"

namespace ldp {

constexpr double kNever = std::numeric_limits<double>::infinity();

// In an object's own axes, from its centre [m].
struct LocalRay {
  Eigen::Vector3d origin, direction;
};

struct Meeting {
  double t = kNever;                                  // along the ray's direction
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of any length
};

// The first meeting beyond t_min, from outside; flat shapes from both sides.
Meeting meet(const LocalRay& ray, Shape shape, const Eigen::Vector3d& half, double t_min);

// Half of the box along the world's axes that holds an object.
Eigen::Vector3d extent_of(const Object& object);

// Position on the surface, metres, second axis up where the object stands upright. `local` and `normal` in its axes.
Eigen::Vector2d face_position(const Object& object, const Eigen::Vector3d& local, const Eigen::Vector3d& normal);

}  // namespace ldp
