#include "scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace ldp {
namespace {

using Eigen::Array3d;
using Eigen::Array3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kGround = -2;  // hills ring i is kGround - 1 - i
constexpr int kSky = -1;
constexpr int kLeafObjects = 3;
constexpr double kNever = std::numeric_limits<double>::infinity();

struct LocalRay {
  Vector3d origin, direction;
};

struct Meeting {
  double t = kNever;
  Vector3d normal = Vector3d::UnitZ();
};

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
  if (root < 0) return {};
  const double side_in = (-b - std::sqrt(root)) / a, side_out = (-b + std::sqrt(root)) / a;
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

Meeting meet_flat(const LocalRay& ray, const Object& object, double t_min) {
  if (ray.direction.z() == 0) return {};
  const double t = -ray.origin.z() / ray.direction.z();
  if (t <= t_min) return {};
  const double x = (ray.origin.x() + t * ray.direction.x()) / object.half.x();
  const double y = (ray.origin.y() + t * ray.direction.y()) / object.half.y();
  if (std::abs(x) > 1 || std::abs(y) > 1) return {};
  if (object.shape == Shape::leaf && !inside_leaf(x, y)) return {};
  return {t, Vector3d(0, 0, ray.direction.z() > 0 ? -1 : 1)};
}

Meeting meet(const LocalRay& ray, const Object& object, double t_min) {
  switch (object.shape) {
    case Shape::ellipsoid: return meet_ellipsoid(ray, object.half, t_min);
    case Shape::cylinder: return meet_cylinder(ray, object.half, t_min);
    case Shape::box: return meet_box(ray, object.half, t_min);
    case Shape::quad:
    case Shape::leaf: return meet_flat(ray, object, t_min);
  }
  return {};
}

Vector3d extent_of(const Object& object) {
  Vector3d half = object.half;
  if (object.shape == Shape::cylinder) half.y() = half.x();
  if (object.shape == Shape::quad || object.shape == Shape::leaf) half.z() = 1e-4;
  return object.world_from_local.cwiseAbs() * half;
}

// Position on the surface, metres, second axis up where the object stands upright.
Eigen::Vector2d face_position(const Object& object, const Vector3d& local, const Vector3d& normal) {
  switch (object.shape) {
    case Shape::box:
      if (std::abs(normal.x()) > 0.5) return {local.y(), local.z()};
      if (std::abs(normal.y()) > 0.5) return {local.x(), local.z()};
      return {local.x(), local.y()};
    case Shape::cylinder: return {std::atan2(local.y(), local.x()) * object.half.x(), local.z()};
    case Shape::ellipsoid: return {std::atan2(local.y(), local.x()) * object.half.x(), local.z()};
    case Shape::quad:
    case Shape::leaf: break;
  }
  return {local.x(), local.y()};
}

// Where the ray's way through the box begins, or kNever when it misses (t_max included).
float box_entry(const Array3f& low, const Array3f& high, const Array3f& origin, const Array3f& inverse, float t_max) {
  const Array3f a = (low - origin) * inverse, b = (high - origin) * inverse;
  const float enter = std::max({std::min(a[0], b[0]), std::min(a[1], b[1]), std::min(a[2], b[2]), 0.0F});
  const float leave = std::min({std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2]), t_max});
  return enter <= leave ? enter : std::numeric_limits<float>::infinity();
}

double skyline(const Hills& hills, const Vector3d& at) {
  const Vector3d around = 6.0 * at / hills.radius;
  return hills.base_height + hills.relief * fractal_noise({around.x(), around.y(), 0.3}, 3.0, 0.004, hills.material.seed);
}

}  // namespace

Scene::Scene(SceneDescription description) : description_(std::move(description)) {
  description_.towards_sun.normalize();
  const std::vector<Object>& objects = description_.objects;
  order_.resize(objects.size());
  std::iota(order_.begin(), order_.end(), 0);
  for (const Object& object : objects) {
    // Float bounds must hold the exact object: a little slack, growing with the distance from the origin.
    const Vector3d extent = extent_of(object).array() + 1e-5 + 1e-6 * object.centre.cwiseAbs().maxCoeff();
    low_.push_back((object.centre - extent).cast<float>().array());
    high_.push_back((object.centre + extent).cast<float>().array());
  }
  if (!objects.empty()) build_node(0, static_cast<int>(objects.size()));
}

// Halves the objects at the median along the widest axis of their centres. Returns the node's index.
int Scene::build_node(int first, int count) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  Array3f low = Array3f::Constant(std::numeric_limits<float>::max()), high = -low, centre_low = low, centre_high = high;
  for (int i = first; i < first + count; ++i) {
    const auto object = static_cast<size_t>(order_[static_cast<size_t>(i)]);
    low = low.min(low_[object]);
    high = high.max(high_[object]);
    const Array3f centre = 0.5F * (low_[object] + high_[object]);
    centre_low = centre_low.min(centre);
    centre_high = centre_high.max(centre);
  }
  nodes_[index].low = low;
  nodes_[index].high = high;
  if (count <= kLeafObjects) {
    nodes_[index].first = first;
    nodes_[index].count = count;
    return static_cast<int>(index);
  }
  Eigen::Index axis = 0;
  (centre_high - centre_low).maxCoeff(&axis);
  const auto key = [&](int object) {
    const auto i = static_cast<size_t>(object);
    return std::pair(low_[i][axis] + high_[i][axis], object);
  };
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](int a, int b) { return key(a) < key(b); });
  build_node(first, count / 2);
  const int right = build_node(first + count / 2, count - count / 2);
  nodes_[index].first = right;
  return static_cast<int>(index);
}

void Scene::find_among_objects(const Ray& ray, double t_min, Found& found) const {
  if (nodes_.empty()) return;
  const Array3f origin = ray.origin.cast<float>().array(), inverse = ray.direction.cast<float>().array().inverse();
  std::array<std::pair<int, float>, 64> stack;
  size_t depth = 0;
  const auto limit = [&] { return static_cast<float>(found.t) * 1.000001F; };
  const auto push = [&](int node, float entry) {
    if (entry < std::numeric_limits<float>::infinity()) stack[depth++] = {node, entry};
  };
  const auto entry_of = [&](int node) {
    const Node& n = nodes_[static_cast<size_t>(node)];
    return box_entry(n.low, n.high, origin, inverse, limit());
  };
  push(0, entry_of(0));
  while (depth > 0) {
    const auto [index, entry] = stack[--depth];
    if (entry > limit()) continue;
    const Node& node = nodes_[static_cast<size_t>(index)];
    if (node.count == 0) {
      const int left = index + 1, right = node.first;
      const float left_entry = entry_of(left), right_entry = entry_of(right);
      const bool left_first = left_entry <= right_entry;
      push(left_first ? right : left, left_first ? right_entry : left_entry);
      push(left_first ? left : right, left_first ? left_entry : right_entry);
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int candidate = order_[static_cast<size_t>(i)];
      const Object& object = description_.objects[static_cast<size_t>(candidate)];
      const Eigen::Matrix3d& axes = object.world_from_local;
      const LocalRay local{axes.transpose() * (ray.origin - object.centre), axes.transpose() * ray.direction};
      const Meeting meeting = meet(local, object, t_min);
      if (meeting.t < found.t) found = {meeting.t, candidate, local.origin + meeting.t * local.direction, meeting.normal};
    }
  }
}

void Scene::find_ground_and_hills(const Ray& ray, double t_min, Found& found) const {
  if (description_.has_ground && ray.direction.z() < 0) {
    const double t = -ray.origin.z() / ray.direction.z();
    if (t > t_min && t < found.t) found = {t, kGround, ray.origin + t * ray.direction, Vector3d::UnitZ()};
  }
  const Vector3d &o = ray.origin, &d = ray.direction;
  const double a = d.x() * d.x() + d.y() * d.y(), b = o.x() * d.x() + o.y() * d.y();
  for (size_t i = 0; i < description_.hills.size(); ++i) {
    const Hills& hills = description_.hills[i];
    const double c = o.x() * o.x() + o.y() * o.y() - hills.radius * hills.radius, root = b * b - a * c;
    if (root < 0 || a == 0) continue;
    const double t = (-b + std::sqrt(root)) / a;  // seen from inside
    if (t <= t_min || t >= found.t) continue;
    const Vector3d at = o + t * d;
    if (at.z() > hills.base_height + 2 * hills.relief || at.z() > skyline(hills, at)) continue;
    found = {t, kGround - 1 - static_cast<int>(i), at, Vector3d(-at.x(), -at.y(), 0)};
  }
}

Vector3f Scene::sky(const Vector3d& direction, double pixel_size) const {
  const Vector3d d = direction.normalized();
  const auto height = static_cast<float>(std::max(d.z(), 0.0));
  const Vector3f horizon{0.62F, 0.74F, 0.88F}, zenith{0.13F, 0.27F, 0.62F};
  const Vector3f blue = horizon + (zenith - horizon) * std::sqrt(height);
  // Clouds lie on a dome that flattens towards the horizon.
  const Vector3d dome = Vector3d(d.x(), d.y(), 0) / (std::max(d.z(), 0.0) + 0.25);
  const float noise = fractal_noise(dome, 0.9, 2 * pixel_size, description_.seed + 77);
  const float cloud = std::clamp(0.9F * (noise + 1.4F * description_.cloud_cover - 0.6F), 0.0F, 0.95F);
  return blue + (Vector3f(0.95F, 0.95F, 0.96F) - blue) * cloud;
}

Vector3f Scene::shade(const Ray& ray, const Found& found) const {
  if (found.object == kSky) return sky(ray.direction, ray.pixel_size);
  TexturePoint point{found.local, Eigen::Vector2d(found.local.x(), found.local.y()), found.t * ray.pixel_size};
  const Material* material = &description_.ground;
  Vector3d normal = found.normal;
  float haze = 0;
  if (found.object >= 0) {
    const Object& object = description_.objects[static_cast<size_t>(found.object)];
    point.face = face_position(object, found.local, found.normal);
    material = &object.material;
    normal = object.world_from_local * found.normal;
  } else if (found.object < kGround) {
    const Hills& hills = description_.hills[static_cast<size_t>(kGround - 1 - found.object)];
    point.face = {std::atan2(found.local.y(), found.local.x()) * hills.radius, found.local.z()};
    material = &hills.material;
    haze = static_cast<float>(1 - std::exp(-hills.radius / 400));
  }
  normal.normalize();
  // Texture on a slanted surface must not be finer than the longer side of a pixel's footprint; half way is sharp
  // enough for the eye and left to supersampling.
  const double slant = std::abs(normal.dot(ray.direction)) / ray.direction.norm();
  point.pixel_m /= std::sqrt(std::max(slant, 0.01));
  const double facing = normal.dot(description_.towards_sun);
  const bool thin = material->pattern == Pattern::leaf;
  const double sun = thin ? 0.3 + 0.7 * std::abs(facing) : std::max(0.0, 0.25 + 0.75 * facing);
  const auto light = static_cast<float>(0.45 + 0.15 * normal.z() + 0.75 * sun);
  const Vector3f lit = light * reflectance(*material, point);
  return lit + (Vector3f(0.55F, 0.66F, 0.8F) - lit) * haze;
}

Hit Scene::first_hit(const Ray& ray, double t_min) const {
  Found found{kNever, kSky, Vector3d::Zero(), Vector3d::UnitZ()};
  find_among_objects(ray, t_min, found);
  find_ground_and_hills(ray, t_min, found);
  return {found.t, found.object, shade(ray, found)};
}

std::vector<Hit> Scene::hits(const Ray& ray, int limit) const {
  std::vector<Hit> all;
  double t_min = 0;
  while (static_cast<int>(all.size()) < limit) {
    all.push_back(first_hit(ray, t_min));
    if (all.back().object == kSky) break;
    t_min = all.back().t * (1 + 1e-9) + 1e-9;
  }
  return all;
}

}  // namespace ldp
