#include "sim/scene/shapes.h"

#include <algorithm>
#include <cmath>

namespace ldp {
namespace {

using Eigen::Vector3d;

Meeting meet_ellipsoid(const LocalRay& ray, const Vector3d& half, double t_min) {
  const Vector3d o = ray.origin.cwiseQuotient(half), d = ray.direction.cwiseQuotient(half);
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1;
  const double root = b * b - a * c;
  if (root < 0) return {};
  const double t = (-b - std::sqrt(root)) / a;
  if (t <= t_min) return {};
  return {t, (o + t * d).cwiseQuotient(half)};
}

Meeting meet_box(const LocalRay& ray, const Vector3d& half, double t_min) {
  double enter = -kNever, leave = kNever;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const double inverse = 1 / ray.direction[i];
    const double a = (-half[i] - ray.origin[i]) * inverse, b = (half[i] - ray.origin[i]) * inverse;
    const double near = std::min(a, b);
    if (near > enter) {
      enter = near;
      axis = i;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter < leave) || enter <= t_min) return {};
  Vector3d normal = Vector3d::Zero();
  normal[axis] = ray.direction[axis] > 0 ? -1 : 1;
  return {enter, normal};
}

Meeting meet_cylinder(const LocalRay& ray, const Vector3d& half, double t_min) {
  const Vector3d &o = ray.origin, &d = ray.direction;
  const double a = d.x() * d.x() + d.y() * d.y(), b = o.x() * d.x() + o.y() * d.y();
  const double c = o.x() * o.x() + o.y() * o.y() - half.x() * half.x(), root = b * b - a * c;
  if (root < 0 || (a == 0 && c > 0)) return {};
  // Along the axis the ray never meets the mantle, only the lids.
  const double side_in = a > 0 ? (-b - std::sqrt(root)) / a : -kNever;
  const double side_out = a > 0 ? (-b + std::sqrt(root)) / a : kNever;
  const double inverse = 1 / d.z(), lid = (-half.z() - o.z()) * inverse, other_lid = (half.z() - o.z()) * inverse;
  const double lid_in = std::min(lid, other_lid), lid_out = std::max(lid, other_lid);
  const double enter = std::max(side_in, lid_in);
  if (!(enter < std::min(side_out, lid_out)) || enter <= t_min) return {};
  if (lid_in > side_in) return {enter, Vector3d(0, 0, d.z() > 0 ? -1 : 1)};
  const Vector3d at = o + enter * d;
  return {enter, Vector3d(at.x(), at.y(), 0)};
}

// A pointed oval along x: |y| below a parabola that closes at both tips.
bool inside_leaf(double x, double y) { return std::abs(y) < (1 - x * x) * (1 - 0.25 * x); }

Meeting meet_flat(const LocalRay& ray, Shape shape, const Vector3d& half, double t_min) {
  if (ray.direction.z() == 0) return {};
  const double t = -ray.origin.z() / ray.direction.z();
  if (t <= t_min) return {};
  const double x = (ray.origin.x() + t * ray.direction.x()) / half.x();
  const double y = (ray.origin.y() + t * ray.direction.y()) / half.y();
  if (std::abs(x) > 1 || std::abs(y) > 1) return {};
  if (shape == Shape::leaf && !inside_leaf(x, y)) return {};
  return {t, Vector3d(0, 0, ray.direction.z() > 0 ? -1 : 1)};
}

}  // namespace

Meeting meet(const LocalRay& ray, Shape shape, const Vector3d& half, double t_min) {
  switch (shape) {
    case Shape::ellipsoid:
      return meet_ellipsoid(ray, half, t_min);
    case Shape::cylinder:
      return meet_cylinder(ray, half, t_min);
    case Shape::box:
      return meet_box(ray, half, t_min);
    case Shape::quad:
    case Shape::leaf:
      return meet_flat(ray, shape, half, t_min);
  }
  return {};
}

Vector3d extent_of(const Object& object) {
  Vector3d half = object.half;
  if (object.shape == Shape::cylinder) half.y() = half.x();
  if (object.shape == Shape::quad || object.shape == Shape::leaf) half.z() = 1e-4;
  return object.world_from_local.cwiseAbs() * half;
}

Eigen::Vector2d face_position(const Object& object, const Vector3d& local, const Vector3d& normal) {
  switch (object.shape) {
    case Shape::box:
      if (std::abs(normal.x()) > 0.5) return {local.y(), local.z()};
      if (std::abs(normal.y()) > 0.5) return {local.x(), local.z()};
      return {local.x(), local.y()};
    case Shape::cylinder:
    case Shape::ellipsoid:
      return {std::atan2(local.y(), local.x()) * object.half.x(), local.z()};
    case Shape::quad:
    case Shape::leaf:
      break;
  }
  return {local.x(), local.y()};
}

}  // namespace ldp
