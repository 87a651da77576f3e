#include "sim/scene/scenes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <stdexcept>

#include "sim/scene/random.h"

namespace ldp {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kFullTurn = 2 * std::numbers::pi;

Vector3d polar(double angle, double distance, double height) {
  return {distance * std::cos(angle), distance * std::sin(angle), height};
}
Matrix3d yawed(double angle) { return AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(); }

Vector3f tinted(const Vector3f& colour, Random& random, double spread) {
  Vector3f result = colour;
  for (float& channel : result) channel *= static_cast<float>(random.uniform(1 - spread, 1 + spread));
  return result;
}

// Places things into a description, giving every thing its own texture seed and, where asked, its own group.
class Builder {
 public:
  explicit Builder(uint32_t seed) : random(seed) { scene.seed = seed; }

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

const Vector3f kGreen{0.16F, 0.34F, 0.07F};
const Vector3f kOlive{0.26F, 0.3F, 0.08F};
const Vector3f kAutumn{0.5F, 0.28F, 0.06F};

void foliage(Builder& b, const Vector3d& centre, const Vector3d& spread, int count, double leaf_length) {
  const Vector3f colours[] = {kGreen, kGreen, kOlive, kAutumn};
  const Vector3f base = colours[b.random.below(4)];
  for (int i = 0; i < count; ++i) {
    b.new_group();
    const Vector3d offset{b.random.normal(), b.random.normal(), b.random.normal()};
    const double length = leaf_length * b.random.uniform(0.6, 1.4);
    b.leaf(centre + 0.5 * offset.cwiseProduct(spread), length, tinted(base, b.random, 0.3));
  }
  b.fixed();
}

void tree(Builder& b, const Vector3d& foot, double height, int leaves) {
  const Material bark = b.bark();
  const double thickness = 0.018 * height + 0.03;
  b.rod(foot, foot + Vector3d(0, 0, 0.8 * height), thickness, bark);
  const int branches = 5 + b.random.below(4);
  for (int i = 0; i < branches; ++i) {
    const double angle = b.random.uniform(0, kFullTurn), from = b.random.uniform(0.4, 0.75) * height;
    const double reach = b.random.uniform(0.15, 0.3) * height, lift = b.random.uniform(0.08, 0.25) * height;
    const Vector3d start = foot + Vector3d(0, 0, from), tip = start + polar(angle, reach, lift);
    b.rod(start, tip, 0.4 * thickness, bark);
    foliage(b, tip, Vector3d(0.26, 0.26, 0.2) * height, leaves / (branches + 1), 0.05 * height + 0.03);
  }
  foliage(b, foot + Vector3d(0, 0, 0.85 * height), Vector3d(0.34, 0.34, 0.26) * height, leaves / (branches + 1),
          0.05 * height + 0.03);
}

// About 1.75 m tall, facing the origin.
void figure(Builder& b, const Vector3d& foot) {
  const double facing = std::atan2(-foot.y(), -foot.x()), tall = b.random.uniform(0.92, 1.06);
  const auto cloth = [&] {
    const Vector3f colour{static_cast<float>(b.random.uniform(0.05, 0.6)),
                          static_cast<float>(b.random.uniform(0.05, 0.5)),
                          static_cast<float>(b.random.uniform(0.05, 0.6))};
    return b.material(Pattern::cloth, 0.35F * colour, (1.5F * colour).cwiseMin(0.9F), b.random.uniform(0.06, 0.2));
  };
  const Vector3d side = yawed(facing) * Vector3d::UnitY();
  const Material coat = cloth(), trousers = cloth();
  const Material skin = b.material(Pattern::mottled, {0.36F, 0.2F, 0.13F}, {0.72F, 0.5F, 0.38F}, 0.08);
  const Material hair = b.material(Pattern::mottled, {0.03F, 0.02F, 0.015F}, {0.25F, 0.16F, 0.09F}, 0.05);
  const auto at = [&](double sideways, double height) {
    return Vector3d(foot + sideways * side + Vector3d(0, 0, height * tall));
  };
  b.new_group();
  b.rod(at(-0.1, 0), at(-0.1, 0.85), 0.085, trousers);
  b.rod(at(0.1, 0), at(0.1, 0.85), 0.085, trousers);
  b.ellipsoid(at(0, 1.12), {0.17, 0.25, 0.38 * tall}, facing, coat);
  b.rod(at(-0.27, 0.8), at(-0.24, 1.38), 0.055, coat);
  b.rod(at(0.27, 0.8), at(0.24, 1.38), 0.055, coat);
  b.ellipsoid(at(0, 1.62), {0.1, 0.085, 0.13}, facing, skin);
  b.ellipsoid(at(0, 1.68) - 0.025 * Vector3d(std::cos(facing), std::sin(facing), 0), {0.105, 0.095, 0.1}, facing, hair);
  b.fixed();
}

void house(Builder& b, double angle, double distance, const Vector3d& half) {
  const double yaw = angle + b.random.uniform(-0.25, 0.25);
  const Vector3f wall = tinted({0.55F, 0.5F, 0.42F}, b.random, 0.3);
  Material front = b.material(Pattern::facade, 0.6F * wall, (1.25F * wall).cwiseMin(0.95F), 2.4);
  front.accent = {0.14F, 0.2F, 0.28F};
  b.box(polar(angle, distance, half.z()), half, yaw, front);
  Material tiles = b.material(Pattern::shingles, {0.17F, 0.06F, 0.045F}, {0.48F, 0.22F, 0.15F}, 0.5);
  tiles.accent = {0.1F, 0.06F, 0.05F};
  b.box(polar(angle, distance, 2 * half.z() + 0.35), half.cwiseProduct(Vector3d(1.08, 1.08, 0)) + Vector3d(0, 0, 0.35),
        yaw, tiles);
  b.box(polar(angle, distance, 2 * half.z() + 1.2), {0.35, 0.35, 1.0}, yaw, b.brick());
}

void houses(Builder& b, int count, double nearest, double farthest) {
  for (int i = 0; i < count; ++i) {
    const double angle = kFullTurn * (i + b.random.uniform(0.1, 0.6)) / count,
                 distance = b.random.uniform(nearest, farthest);
    house(b, angle, distance, {b.random.uniform(2.5, 4), b.random.uniform(3, 6), b.random.uniform(2.4, 4.5)});
  }
}

// Posts and rails along a part of a circle.
void railing(Builder& b, double radius, double from, double to, double spacing) {
  const Material metal = b.metal();
  const int bars = static_cast<int>(std::ceil((to - from) * radius / spacing));
  for (int i = 0; i <= bars; ++i) {
    const double angle = from + (to - from) * i / bars, next = from + (to - from) * (i + 1) / bars;
    b.rod(polar(angle, radius, 0), polar(angle, radius, 1.05), i % 8 == 0 ? 0.022 : 0.008, metal);
    if (i == bars) break;
    b.rod(polar(angle, radius, 1.05), polar(next, radius, 1.05), 0.022, metal);
    b.rod(polar(angle, radius, 0.12), polar(next, radius, 0.12), 0.012, metal);
  }
}

void lamp_post(Builder& b, const Vector3d& foot, double height) {
  const Material metal = b.metal();
  b.rod(foot, foot + Vector3d(0, 0, height), 0.045, metal);
  b.rod(foot, foot + Vector3d(0, 0, 0.5), 0.09, metal);
  b.ellipsoid(foot + Vector3d(0, 0, height + 0.16), {0.2, 0.2, 0.2}, 0,
              b.material(Pattern::mottled, {0.6F, 0.58F, 0.5F}, {0.95F, 0.93F, 0.85F}, 0.15));
}

void planter(Builder& b, const Vector3d& foot, double height, int leaves) {
  const Material clay = b.material(Pattern::mottled, {0.28F, 0.1F, 0.06F}, {0.62F, 0.3F, 0.18F}, 0.12);
  b.rod(foot, foot + Vector3d(0, 0, height), 0.22, clay);
  for (int i = 0; i < 5; ++i) {
    const Vector3d tip = foot + polar(b.random.uniform(0, kFullTurn), 0.2, height + b.random.uniform(0.3, 0.7));
    b.rod(foot + Vector3d(0, 0, height), tip, 0.012, b.bark());
    foliage(b, tip, {0.3, 0.3, 0.3}, leaves / 5, 0.16);
  }
}

// Straight low wall standing across the direction `angle`.
void low_wall(Builder& b, double angle, double distance, double half_width, double height) {
  b.box(polar(angle, distance, 0.5 * height), {0.14, half_width, 0.5 * height}, angle, b.brick());
  b.box(polar(angle, distance, height + 0.04), {0.18, half_width + 0.04, 0.04}, angle, b.stone());
}

void countryside(Builder& b) {
  b.scene.hills.push_back(
      {60, 3.5, 2.5, b.material(Pattern::mottled, {0.04F, 0.09F, 0.03F}, {0.26F, 0.36F, 0.14F}, 5)});
  b.scene.hills.push_back({220, 16, 14, b.material(Pattern::mottled, {0.1F, 0.16F, 0.08F}, {0.38F, 0.42F, 0.26F}, 25)});
  b.scene.hills.push_back({700, 70, 60, b.material(Pattern::mottled, {0.2F, 0.22F, 0.24F}, {0.5F, 0.5F, 0.52F}, 120)});
}

SceneDescription garden(uint32_t seed) {
  Builder b(seed);
  b.scene.ground = b.material(Pattern::mottled, {0.06F, 0.13F, 0.025F}, {0.3F, 0.42F, 0.12F}, 0.8);
  countryside(b);
  houses(b, 9, 14, 24);
  for (int i = 0; i < 14; ++i) {
    const double angle = kFullTurn * (i + b.random.uniform(0, 0.7)) / 14, distance = b.random.uniform(3.2, 8);
    tree(b, polar(angle, distance, 0), b.random.uniform(3.2, 5.5), 220);
  }
  for (int i = 0; i < 10; ++i) {
    const double angle = kFullTurn * (i + b.random.uniform(0, 0.8)) / 10, distance = b.random.uniform(1.9, 3.2);
    foliage(b, polar(angle, distance, b.random.uniform(0.5, 1.1)), {0.8, 0.8, 0.9}, 40, 0.22);
  }
  for (int i = 0; i < 4; ++i)
    figure(b, polar(kFullTurn * (i + b.random.uniform(0.2, 0.8)) / 4, b.random.uniform(2.0, 3.5), 0));
  for (int i = 0; i < 4; ++i) low_wall(b, kFullTurn * (i + 0.3) / 4, 4.2, 1.6, 0.7);
  return b.scene;
}

SceneDescription courtyard(uint32_t seed) {
  Builder b(seed);
  b.scene.ground = b.material(Pattern::bricks, {0.2F, 0.19F, 0.17F}, {0.55F, 0.52F, 0.47F}, 0.5);
  b.scene.ground.accent = {0.14F, 0.13F, 0.11F};
  countryside(b);
  houses(b, 11, 10, 15);
  for (int i = 0; i < 5; ++i) {
    const double angle = kFullTurn * (i + b.random.uniform(0.1, 0.6)) / 5;
    lamp_post(b, polar(angle, b.random.uniform(2.4, 4.5), 0), b.random.uniform(2.6, 3.4));
    planter(b, polar(angle + b.random.uniform(0.3, 0.6), b.random.uniform(1.7, 2.6), 0), 0.75, 60);
    tree(b, polar(angle + b.random.uniform(0.6, 1.0), b.random.uniform(4.5, 7.5), 0), b.random.uniform(3.5, 5), 160);
  }
  for (int i = 0; i < 6; ++i)
    figure(b, polar(kFullTurn * (i + b.random.uniform(0.1, 0.9)) / 6, b.random.uniform(1.9, 6), 0));
  for (int i = 0; i < 6; ++i)
    low_wall(b, kFullTurn * (i + b.random.uniform(0.1, 0.4)) / 6, b.random.uniform(3, 5), 1.3,
             b.random.uniform(0.5, 1.0));
  railing(b, 6.5, 0.4, 2.4, 0.14);
  return b.scene;
}

void table(Builder& b, const Vector3d& foot, double yaw) {
  const Material wood = b.wood();
  b.box(foot + Vector3d(0, 0, 0.73), {0.4, 0.7, 0.025}, yaw, wood);
  for (const double x : {-0.35, 0.35}) {
    for (const double y : {-0.64, 0.64}) {
      const Vector3d leg = foot + yawed(yaw) * Vector3d(x, y, 0);
      b.rod(leg, leg + Vector3d(0, 0, 0.72), 0.03, wood);
    }
  }
  for (int i = 0; i < 5; ++i) {
    const Vector3d on_top = foot + yawed(yaw) * Vector3d(b.random.uniform(-0.3, 0.3), -0.55 + 0.26 * i, 0.755);
    const double size = b.random.uniform(0.06, 0.13);
    const Vector3f colour = tinted({0.35F, 0.3F, 0.3F}, b.random, 0.9);
    const Material m = b.material(i % 2 == 0 ? Pattern::mottled : Pattern::cloth, 0.4F * colour,
                                  (1.6F * colour).cwiseMin(0.95F), 0.08);
    if (i % 2 == 0)
      b.ellipsoid(on_top + Vector3d(0, 0, 1.3 * size), {size, size, 1.3 * size}, 0, m);
    else
      b.box(on_top + Vector3d(0, 0, size), {0.7 * size, size, size}, b.random.uniform(0, 1.5), m);
  }
}

void bookshelf(Builder& b, const Vector3d& foot, double yaw) {
  const Material wood = b.wood();
  const auto place = [&](double x, double y, double z) { return Vector3d(foot + yawed(yaw) * Vector3d(x, y, z)); };
  for (const double y : {-0.6, 0.6}) b.box(place(0, y, 1.0), {0.15, 0.02, 1.0}, yaw, wood);
  for (int shelf = 0; shelf < 5; ++shelf) {
    const double height = 0.05 + 0.48 * shelf;
    b.box(place(0, 0, height), {0.15, 0.6, 0.015}, yaw, wood);
    if (shelf == 4) break;
    double y = -0.56;
    while (y < 0.5) {
      const double width = b.random.uniform(0.012, 0.035), tall = b.random.uniform(0.11, 0.19);
      const Vector3f colour = tinted({0.3F, 0.25F, 0.25F}, b.random, 0.9);
      b.box(place(b.random.uniform(-0.02, 0.02), y + width, height + 0.015 + tall), {0.1, width, tall}, yaw,
            b.material(Pattern::cloth, 0.4F * colour, (1.6F * colour).cwiseMin(0.95F), 0.07));
      y += 2 * width + (b.random.uniform() < 0.12 ? 0.1 : 0.004);
    }
  }
}

// Four walls with a window in the second one, floor and ceiling.
void walls(Builder& b, double west, double east, double south, double north) {
  const double height = 2.7, thick = 0.1, mid_x = 0.5 * (west + east), mid_y = 0.5 * (south + north);
  const double half_x = 0.5 * (east - west), half_y = 0.5 * (north - south);
  const Material paper = b.material(Pattern::mottled, {0.34F, 0.31F, 0.24F}, {0.8F, 0.76F, 0.66F}, 0.18);
  Material tiles = b.material(Pattern::bricks, {0.3F, 0.4F, 0.42F}, {0.72F, 0.78F, 0.76F}, 0.3);
  tiles.accent = {0.85F, 0.85F, 0.82F};
  b.box({mid_x, south - thick, height / 2}, {half_x, thick, height / 2}, 0, paper);
  b.box({west - thick, mid_y, height / 2}, {thick, half_y, height / 2}, 0, b.brick());
  b.box({east + thick, mid_y, height / 2}, {thick, half_y, height / 2}, 0, tiles);
  // North wall: 1.6 m wide window from 0.9 m to 2.2 m.
  b.box({mid_x, north + thick, 0.45}, {half_x, thick, 0.45}, 0, paper);
  b.box({mid_x, north + thick, 2.45}, {half_x, thick, 0.25}, 0, paper);
  for (const double sign : {-1.0, 1.0}) {
    const double half = 0.5 * (half_x - 0.8);
    b.box({mid_x + sign * (0.8 + half), north + thick, 1.55}, {half, thick, 0.65}, 0, paper);
    b.rod({mid_x + sign * 0.01, north, 0.9}, {mid_x + sign * 0.01, north, 2.2}, 0.02, b.wood());
  }
  b.box({mid_x, mid_y, -0.05}, {half_x + 0.2, half_y + 0.2, 0.05}, 0, b.wood());
  b.box({mid_x, mid_y, height + 0.05}, {half_x + 0.2, half_y + 0.2, 0.05}, 0,
        b.material(Pattern::mottled, {0.5F, 0.5F, 0.48F}, {0.88F, 0.88F, 0.86F}, 0.3));
}

SceneDescription room(uint32_t seed) {
  Builder b(seed);
  b.scene.ground = b.material(Pattern::mottled, {0.06F, 0.13F, 0.025F}, {0.3F, 0.42F, 0.12F}, 0.8);
  countryside(b);
  houses(b, 8, 14, 25);
  const double west = -1.65 - b.random.uniform(0, 0.15), east = 2.6 + b.random.uniform(0, 0.6);
  const double south = -2.4 - b.random.uniform(0, 0.5), north = 3.0 + b.random.uniform(0, 0.6);
  walls(b, west, east, south, north);
  table(b, {1.7, 1.1, 0}, 0.2);
  table(b, {-0.3, 2.2, 0}, std::numbers::pi / 2);
  bookshelf(b, {east - 0.18, -0.7, 0}, std::numbers::pi);
  bookshelf(b, {-0.9, south + 0.18, 0}, std::numbers::pi / 2);
  planter(b, {1.9, 2.3, 0}, 0.5, 70);
  planter(b, {-1.0, 1.6, 0}, 0.7, 70);
  figure(b, {0.9, -1.7, 0});
  figure(b, {1.2, 2.3, 0});
  lamp_post(b, {0.55, 1.85, 0}, 1.55);
  for (int i = 0; i < 4; ++i) {
    Material art = b.material(Pattern::picture, tinted({0.1F, 0.12F, 0.2F}, b.random, 0.8),
                              tinted({0.7F, 0.6F, 0.4F}, b.random, 0.4), 0.3);
    art.accent = tinted({0.6F, 0.25F, 0.15F}, b.random, 0.6);
    const double along = -1.6 + 1.15 * i, half_width = b.random.uniform(0.25, 0.4),
                 half_height = b.random.uniform(0.2, 0.35);
    b.pane({west + 0.012, along, 1.6}, half_width, half_height, 0, art);
    if (i > 1) b.pane({0.4 * i - 0.2, south + 0.012, 1.65}, half_height, half_width, std::numbers::pi / 2, art);
  }
  return b.scene;
}

SceneDescription terrace(uint32_t seed) {
  Builder b(seed);
  b.scene.ground = b.material(Pattern::mottled, {0.08F, 0.14F, 0.04F}, {0.36F, 0.4F, 0.18F}, 3);
  countryside(b);
  houses(b, 13, 24, 48);
  for (int i = 0; i < 24; ++i) {
    tree(b, polar(kFullTurn * (i + b.random.uniform(0, 0.8)) / 24, b.random.uniform(21, 40), 0), b.random.uniform(4, 8),
         90);
  }
  Material paving = b.material(Pattern::checks, {0.24F, 0.2F, 0.16F}, {0.58F, 0.52F, 0.45F}, 0.4);
  b.rod({0, 0, -0.02}, {0, 0, 0.02}, 2.6, paving);
  railing(b, 2.3, 0, kFullTurn, 0.13);
  for (int i = 0; i < 7; ++i)
    planter(b, polar(kFullTurn * (i + b.random.uniform(0.1, 0.7)) / 7, b.random.uniform(1.65, 2.05), 0.02),
            b.random.uniform(0.45, 0.8), 50);
  for (int i = 0; i < 3; ++i) {
    const double angle = kFullTurn * (i + 0.4) / 3;
    b.rod(polar(angle, 2.0, 0), polar(angle, 2.0, 2.6), 0.05, b.wood());
  }
  return b.scene;
}

SceneDescription repeated(uint32_t seed) {
  Builder b(seed);
  b.scene.ground = b.material(Pattern::checks, {0.08F, 0.08F, 0.09F}, {0.7F, 0.69F, 0.65F}, 0.5);
  countryside(b);
  const Material brick = b.brick();
  for (int i = 0; i < 8; ++i) b.box(polar(kFullTurn * i / 8, 8, 1.6), {0.2, 3.4, 1.6}, kFullTurn * i / 8, brick);
  for (int i = 0; i < 24; ++i) {
    const double angle = kFullTurn * i / 24;
    b.rod(polar(angle, 4.5, 0), polar(angle, 4.5, 2.8), 0.14, b.stone());
    b.box(polar(angle, 4.5, 2.88), {0.2, 0.2, 0.08}, angle, b.stone());
  }
  railing(b, 2.6, 0, kFullTurn, 0.12);
  for (int i = 0; i < 12; ++i) {
    const double angle = kFullTurn * (i + 0.5) / 12;
    b.box(polar(angle, 1.9, 0.3), {0.15, 0.15, 0.3}, angle,
          b.material(Pattern::checks, {0.1F, 0.12F, 0.3F}, {0.75F, 0.74F, 0.6F}, 0.1));
  }
  houses(b, 16, 20, 20.5);
  return b.scene;
}

SceneDescription figures(uint32_t seed) {
  Builder b(seed);
  b.scene.ground = b.material(Pattern::bricks, {0.22F, 0.2F, 0.18F}, {0.58F, 0.55F, 0.5F}, 0.6);
  b.scene.ground.accent = {0.15F, 0.14F, 0.13F};
  countryside(b);
  houses(b, 12, 16, 22);
  for (int i = 0; i < 9; ++i)
    figure(b, polar(kFullTurn * (i + b.random.uniform(0, 0.8)) / 9, b.random.uniform(1.85, 2.6), 0));
  for (int i = 0; i < 22; ++i)
    figure(b, polar(kFullTurn * (i + b.random.uniform(0, 0.9)) / 22, b.random.uniform(3, 6), 0));
  for (int i = 0; i < 26; ++i)
    figure(b, polar(kFullTurn * (i + b.random.uniform(0, 0.9)) / 26, b.random.uniform(6.5, 12.5), 0));
  for (int i = 0; i < 4; ++i)
    lamp_post(b, polar(kFullTurn * (i + b.random.uniform(0, 0.9)) / 4, b.random.uniform(3, 7), 0), 3.2);
  return b.scene;
}

const std::map<std::string, std::function<SceneDescription(uint32_t)>>& makers() {
  static const std::map<std::string, std::function<SceneDescription(uint32_t)>> all = {
      {"courtyard", courtyard}, {"figures", figures}, {"garden", garden},
      {"repeated", repeated},   {"room", room},       {"terrace", terrace}};
  return all;
}

}  // namespace

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const auto& [name, maker] : makers()) all.push_back(name);
    return all;
  }();
  return names;
}

SceneDescription make_scene(const std::string& name, uint32_t seed) {
  const auto found = makers().find(name);
  if (found != makers().end()) return found->second(seed);
  std::string known;
  for (const std::string& other : scene_names()) known += (known.empty() ? "" : ", ") + other;
  throw std::invalid_argument("no scene is called '" + name + "'; there are " + known);
}

SceneDescription moved(const SceneDescription& scene, double share, int frame, uint32_t seed) {
  SceneDescription later = scene;
  if (share <= 0) return later;
  for (Object& object : later.objects) {
    if (object.group == 0) continue;
    Random way(mix_bits(seed) ^ static_cast<uint64_t>(object.group));
    if (way.uniform() >= share) continue;
    // Leaves sway about their place, figures walk on.
    const double heading = way.uniform(0, kFullTurn), phase = way.uniform(0, kFullTurn);
    const bool sways = object.shape == Shape::leaf;
    const double distance = sways ? 0.03 * std::sin(phase + 1.9 * frame) : 0.12 * frame;
    object.centre += polar(heading, distance, 0);
  }
  return later;
}

}  // namespace ldp
