// Puts a synthetic scene together, thing by thing: shapes of materials, in metres, z up, the photographer at the
// origin.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "sim/scene/random.h"
#include "sim/scene/scene.h"

namespace ldp::scene {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kFullTurn = 2 * std::numbers::pi;

inline Vector3d polar(double angle, double distance, double height) {
  return {distance * std::cos(angle), distance * std::sin(angle), height};
}
inline Matrix3d yawed(double angle) { return AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(); }

inline Vector3f tinted(const Vector3f& colour, Random& random, double spread) {
  Vector3f result = colour;
  for (float& channel : result) channel *= static_cast<float>(random.uniform(1 - spread, 1 + spread));
  return result;
}

// Places things into a description, giving every thing its own texture seed and, where asked, its own group.
class SceneBuilder {
 public:
  explicit SceneBuilder(uint32_t seed) : random(seed) { scene.seed = seed; }

  SceneDescription scene;
  Random random;

  Material material(Pattern pattern, const Vector3f& dark, const Vector3f& light, double size_m) {
    Material m;
    m.pattern = pattern;
    m.dark = dark;
    m.light = light;
    m.size_m = static_cast<float>(size_m);
    m.seed = static_cast<uint32_t>(random.bits() & 0xFFFFFF);
    return m;
  }
  Material bark() { return material(Pattern::mottled, {0.05F, 0.035F, 0.025F}, {0.3F, 0.22F, 0.16F}, 0.2); }
  Material metal() { return material(Pattern::mottled, {0.04F, 0.05F, 0.05F}, {0.2F, 0.22F, 0.22F}, 0.2); }
  Material brick() {
    Material m = material(Pattern::bricks, {0.16F, 0.05F, 0.035F}, {0.52F, 0.23F, 0.15F}, 0.24);
    m.accent = {0.55F, 0.52F, 0.47F};
    return m;
  }
  Material stone() { return material(Pattern::mottled, {0.18F, 0.17F, 0.15F}, {0.62F, 0.6F, 0.54F}, 0.35); }
  Material wood() { return material(Pattern::planks, {0.14F, 0.075F, 0.035F}, {0.5F, 0.32F, 0.17F}, 0.14); }

  void box(const Vector3d& centre, const Vector3d& half, double yaw, const Material& m) {
    add(Shape::box, centre, yawed(yaw), half, m);
  }
  void ellipsoid(const Vector3d& centre, const Vector3d& half, double yaw, const Material& m) {
    add(Shape::ellipsoid, centre, yawed(yaw), half, m);
  }
  void rod(const Vector3d& from, const Vector3d& to, double radius, const Material& m) {
    const Vector3d along = to - from;
    const Matrix3d axes = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along).toRotationMatrix();
    add(Shape::cylinder, 0.5 * (from + to), axes, {radius, radius, 0.5 * along.norm()}, m);
  }
  // A picture or pane that faces the direction `facing` (horizontal angle).
  void pane(const Vector3d& centre, double half_width, double half_height, double facing, const Material& m) {
    Matrix3d axes;
    axes << -std::sin(facing), 0, std::cos(facing), std::cos(facing), 0, std::sin(facing), 0, 1, 0;
    add(Shape::quad, centre, axes, {half_width, half_height, 0}, m);
  }
  void leaf(const Vector3d& centre, double length, const Vector3f& colour) {
    Material m = material(Pattern::leaf, 0.45F * colour, 1.3F * colour, length);
    m.accent = {0.4F, 0.48F, 0.18F};
    const double yaw = random.uniform(0, kFullTurn), pitch = random.uniform(-1.1, 1.1),
                 roll = random.uniform(-1.0, 1.0);
    const Matrix3d axes = (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
                           AngleAxisd(roll, Vector3d::UnitX()))
                              .toRotationMatrix();
    add(Shape::leaf, centre, axes, {0.5 * length, random.uniform(0.16, 0.28) * length, 0}, m);
  }
  void new_group() { group_ = ++groups_; }
  void fixed() { group_ = 0; }

 private:
  void add(Shape shape, const Vector3d& centre, const Matrix3d& axes, const Vector3d& half, const Material& m) {
    scene.objects.push_back({shape, centre, axes, half, m, group_});
  }
  int group_ = 0, groups_ = 0;
};

}  // namespace ldp::scene
