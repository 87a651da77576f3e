#include "sim/scene/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "sim/scene/shapes.h"

namespace ldp {
namespace {

using Eigen::Array4f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kGround = -2;  // hills ring i is kGround - 1 - i
constexpr int kSky = -1;
constexpr float kVisitCost = 0.6F;  // of a node, in object tests
constexpr size_t kDeepestTree = 128;

Array4f padded(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0.0F};
}

// A ray prepared for boxes. The fourth lane holds the ray's own limits: it starts at 0.
struct SlabRay {
  Array4f origin, inverse;

  explicit SlabRay(const Ray& ray) : origin(padded(ray.origin)), inverse(padded(ray.direction).inverse()) {
    inverse[3] = 1;
  }
  // Where the ray's way through the box begins; infinity when it misses or begins beyond the limit.
  float entry(const Array4f& low, const Array4f& high, float limit) const {
    const Array4f a = (low - origin) * inverse, b = (high - origin) * inverse;
    const Array4f near = a.min(b);
    Array4f far = a.max(b);
    far[3] = limit;
    const float enter = near.maxCoeff();
    return enter <= far.minCoeff() ? enter : std::numeric_limits<float>::infinity();
  }
};

double skyline(const Hills& hills, const Vector3d& at) {
  const Vector3d around = 6.0 * at / hills.radius;
  return hills.base_height +
         hills.relief * fractal_noise({around.x(), around.y(), 0.3}, 3.0, 0.004, hills.material.seed);
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
    boxes_.push_back({padded(object.centre - extent), padded(object.centre + extent)});
  }
  if (!objects.empty()) build_node(0, static_cast<int>(objects.size()));
  for (const int index : order_) {
    const Object& object = objects[static_cast<size_t>(index)];
    solids_.push_back({object.world_from_local.transpose(), object.centre, object.half, object.shape});
  }
}

// Splits where the surface area heuristic expects the least work, along the best of the three axes. Returns the node's
// index; the left child follows its parent, the right one is named by it.
int Scene::build_node(int first, int count) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  const Box bounds = bounds_of(first, count);
  nodes_[index].low = bounds.low;
  nodes_[index].high = bounds.high;
  const int left_count = count <= 1 ? 0 : split(first, count, bounds.area());
  if (left_count == 0) {
    nodes_[index].first = first;
    nodes_[index].count = count;
    return static_cast<int>(index);
  }
  build_node(first, left_count);
  const int right = build_node(first + left_count, count - left_count);
  nodes_[index].first = right;
  return static_cast<int>(index);
}

Scene::Box Scene::bounds_of(int first, int count) const {
  Box all;
  for (int i = first; i < first + count; ++i) all.add(boxes_[static_cast<size_t>(order_[static_cast<size_t>(i)])]);
  return all;
}

void Scene::sort_along(int first, int count, int axis) {
  const auto key = [&](int object) {
    const Box& box = boxes_[static_cast<size_t>(object)];
    return std::pair(box.low[axis] + box.high[axis], object);
  };
  const auto begin = order_.begin() + first;
  std::sort(begin, begin + count, [&](int a, int b) { return key(a) < key(b); });
}

// Reorders the range; returns how many objects go left, 0 to keep all in one leaf.
int Scene::split(int first, int count, float whole_area) {
  float best_cost = static_cast<float>(count);
  int best_axis = -1, best_left = 0;
  std::vector<float> left_area(static_cast<size_t>(count));
  for (int axis = 0; axis < 3; ++axis) {
    sort_along(first, count, axis);
    Box growing;
    for (int i = 0; i < count; ++i) {
      growing.add(boxes_[static_cast<size_t>(order_[static_cast<size_t>(first + i)])]);
      left_area[static_cast<size_t>(i)] = growing.area();
    }
    Box right;
    for (int i = count - 1; i > 0; --i) {
      right.add(boxes_[static_cast<size_t>(order_[static_cast<size_t>(first + i)])]);
      const float work =
          left_area[static_cast<size_t>(i - 1)] * static_cast<float>(i) + right.area() * static_cast<float>(count - i);
      const float cost = kVisitCost + work / whole_area;
      if (cost >= best_cost) continue;
      best_cost = cost;
      best_axis = axis;
      best_left = i;
    }
  }
  if (best_axis < 0) return 0;
  sort_along(first, count, best_axis);
  return best_left;
}

void Scene::find_among_objects(const Ray& ray, double t_min, Found& found) const {
  if (nodes_.empty()) return;
  const SlabRay slab(ray);
  struct Waiting {
    int node;
    float entry;
  };
  std::array<Waiting, kDeepestTree> stack;
  size_t depth = 0;
  float limit = std::numeric_limits<float>::max();  // below infinity, which stands for a miss
  int node_index = 0;
  float entry = slab.entry(nodes_[0].low, nodes_[0].high, limit);
  while (true) {
    if (entry <= limit) {
      const Node& node = nodes_[static_cast<size_t>(node_index)];
      if (node.count == 0) {
        const int left = node_index + 1, right = node.first;
        const float left_entry =
            slab.entry(nodes_[static_cast<size_t>(left)].low, nodes_[static_cast<size_t>(left)].high, limit);
        const float right_entry =
            slab.entry(nodes_[static_cast<size_t>(right)].low, nodes_[static_cast<size_t>(right)].high, limit);
        const bool left_first = left_entry <= right_entry;
        const float far_entry = left_first ? right_entry : left_entry;
        if (far_entry <= limit && depth < stack.size()) stack[depth++] = {left_first ? right : left, far_entry};
        node_index = left_first ? left : right;
        entry = left_first ? left_entry : right_entry;
        continue;
      }
      for (int i = node.first; i < node.first + node.count; ++i) {
        const Solid& solid = solids_[static_cast<size_t>(i)];
        const LocalRay local{solid.local_from_world * (ray.origin - solid.centre),
                             solid.local_from_world * ray.direction};
        const Meeting meeting = meet(local, solid.shape, solid.half, t_min);
        if (meeting.t >= found.t) continue;
        found = {meeting.t, order_[static_cast<size_t>(i)], local.origin + meeting.t * local.direction, meeting.normal};
        limit = std::nextafter(static_cast<float>(found.t), std::numeric_limits<float>::max());
      }
    }
    if (depth == 0) return;
    --depth;
    node_index = stack[depth].node;
    entry = stack[depth].entry;
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

Vector3f Scene::reflected(const Ray& ray, const Found& found) const {
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

float Scene::light_at(const Vector3d& place) const {
  if (description_.shade == 1) return 1;
  constexpr double kEdge = 0.2;  // sine of the angle over which light becomes shade
  const double across = place.x() / std::max(1e-9, std::hypot(place.x(), place.y()));
  const auto sunny = static_cast<float>(std::clamp(across / kEdge + 0.5, 0.0, 1.0));
  return description_.shade + (1 - description_.shade) * sunny * sunny * (3 - 2 * sunny);
}

Hit Scene::first_hit(const Ray& ray, double t_min) const {
  Found found{kNever, kSky, Vector3d::Zero(), Vector3d::UnitZ()};
  find_among_objects(ray, t_min, found);
  find_ground_and_hills(ray, t_min, found);
  const bool is_sky = found.object == kSky;
  const Vector3f light =
      light_at(is_sky ? ray.direction : ray.origin + found.t * ray.direction) * reflected(ray, found);
  return {found.t, found.object, light};
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
