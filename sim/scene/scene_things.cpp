#include "sim/scene/scene_things.h"

#include <cmath>

namespace ldp::scene {
namespace {

const Vector3f kGreen{0.16F, 0.34F, 0.07F};
const Vector3f kOlive{0.26F, 0.3F, 0.08F};
const Vector3f kAutumn{0.5F, 0.28F, 0.06F};

}  // namespace

void foliage(SceneBuilder& b, const Vector3d& centre, const Vector3d& spread, int count, double leaf_length) {
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

void tree(SceneBuilder& b, const Vector3d& foot, double height, int leaves) {
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

void figure(SceneBuilder& b, const Vector3d& foot) { figure(b, foot, std::atan2(-foot.y(), -foot.x()), 0); }

// About 1.75 m tall.
void figure(SceneBuilder& b, const Vector3d& foot, double facing, double stride) {
  const double tall = b.random.uniform(0.92, 1.06);
  const auto cloth = [&] {
    const Vector3f colour{static_cast<float>(b.random.uniform(0.05, 0.6)),
                          static_cast<float>(b.random.uniform(0.05, 0.5)),
                          static_cast<float>(b.random.uniform(0.05, 0.6))};
    return b.material(Pattern::cloth, 0.35F * colour, (1.5F * colour).cwiseMin(0.9F), b.random.uniform(0.06, 0.2));
  };
  const Vector3d side = yawed(facing) * Vector3d::UnitY(), swing = std::sin(stride) * polar(facing, 0.28, 0);
  const Material coat = cloth(), trousers = cloth();
  const Material skin = b.material(Pattern::mottled, {0.36F, 0.2F, 0.13F}, {0.72F, 0.5F, 0.38F}, 0.08);
  const Material hair = b.material(Pattern::mottled, {0.03F, 0.02F, 0.015F}, {0.25F, 0.16F, 0.09F}, 0.05);
  const auto at = [&](double sideways, double height) {
    return Vector3d(foot + sideways * side + Vector3d(0, 0, height * tall));
  };
  b.new_group();
  b.rod(at(-0.1, 0) + swing, at(-0.1, 0.85), 0.085, trousers);
  b.rod(at(0.1, 0) - swing, at(0.1, 0.85), 0.085, trousers);
  b.ellipsoid(at(0, 1.12), {0.17, 0.25, 0.38 * tall}, facing, coat);
  b.rod(at(-0.27, 0.8) - swing, at(-0.24, 1.38), 0.055, coat);
  b.rod(at(0.27, 0.8) + swing, at(0.24, 1.38), 0.055, coat);
  b.ellipsoid(at(0, 1.62), {0.1, 0.085, 0.13}, facing, skin);
  b.ellipsoid(at(0, 1.68) - 0.025 * Vector3d(std::cos(facing), std::sin(facing), 0), {0.105, 0.095, 0.1}, facing, hair);
  b.fixed();
}

void house(SceneBuilder& b, double angle, double distance, const Vector3d& half) {
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

void houses(SceneBuilder& b, int count, double nearest, double farthest) {
  for (int i = 0; i < count; ++i) {
    const double angle = kFullTurn * (i + b.random.uniform(0.1, 0.6)) / count,
                 distance = b.random.uniform(nearest, farthest);
    house(b, angle, distance, {b.random.uniform(2.5, 4), b.random.uniform(3, 6), b.random.uniform(2.4, 4.5)});
  }
}

// Posts and rails along a part of a circle.
void railing(SceneBuilder& b, double radius, double from, double to, double spacing) {
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

// As thick as a finger, slack by a fiftieth of its length.
void wire(SceneBuilder& b, const Vector3d& from, const Vector3d& to, const Material& m) {
  constexpr int kPieces = 8;
  const auto at = [&](int i) {
    const double share = static_cast<double>(i) / kPieces, slack = 0.02 * (to - from).norm();
    return Vector3d(from + share * (to - from) - Vector3d(0, 0, 4 * slack * share * (1 - share)));
  };
  for (int i = 0; i < kPieces; ++i) b.rod(at(i), at(i + 1), 0.0065, m);
}

// Tall grass: stalks that rise straight and then bend outwards.
void tuft(SceneBuilder& b, const Vector3d& foot, double height, int stalks) {
  for (int i = 0; i < stalks; ++i) {
    const Vector3f colour = tinted(kOlive, b.random, 0.4);
    const Material blade = b.material(Pattern::mottled, 0.5F * colour, 1.6F * colour, 0.1);
    const double angle = b.random.uniform(0, kFullTurn), tall = height * b.random.uniform(0.7, 1);
    const Vector3d root = foot + polar(angle, b.random.uniform(0, 0.08), 0);
    const Vector3d bend = root + polar(angle, 0.1 * tall, 0.6 * tall);
    b.rod(root, bend, 0.006, blade);
    b.rod(bend, root + polar(angle, 0.3 * tall, tall), 0.004, blade);
  }
}

void lamp_post(SceneBuilder& b, const Vector3d& foot, double height) {
  const Material metal = b.metal();
  b.rod(foot, foot + Vector3d(0, 0, height), 0.045, metal);
  b.rod(foot, foot + Vector3d(0, 0, 0.5), 0.09, metal);
  b.ellipsoid(foot + Vector3d(0, 0, height + 0.16), {0.2, 0.2, 0.2}, 0,
              b.material(Pattern::mottled, {0.6F, 0.58F, 0.5F}, {0.95F, 0.93F, 0.85F}, 0.15));
}

void planter(SceneBuilder& b, const Vector3d& foot, double height, int leaves) {
  const Material clay = b.material(Pattern::mottled, {0.28F, 0.1F, 0.06F}, {0.62F, 0.3F, 0.18F}, 0.12);
  b.rod(foot, foot + Vector3d(0, 0, height), 0.22, clay);
  for (int i = 0; i < 5; ++i) {
    const Vector3d tip = foot + polar(b.random.uniform(0, kFullTurn), 0.2, height + b.random.uniform(0.3, 0.7));
    b.rod(foot + Vector3d(0, 0, height), tip, 0.012, b.bark());
    foliage(b, tip, {0.3, 0.3, 0.3}, leaves / 5, 0.16);
  }
}

// Straight low wall standing across the direction `angle`.
void low_wall(SceneBuilder& b, double angle, double distance, double half_width, double height) {
  b.box(polar(angle, distance, 0.5 * height), {0.14, half_width, 0.5 * height}, angle, b.brick());
  b.box(polar(angle, distance, height + 0.04), {0.18, half_width + 0.04, 0.04}, angle, b.stone());
}

void countryside(SceneBuilder& b) {
  b.scene.hills.push_back(
      {60, 3.5, 2.5, b.material(Pattern::mottled, {0.04F, 0.09F, 0.03F}, {0.26F, 0.36F, 0.14F}, 5)});
  b.scene.hills.push_back({220, 16, 14, b.material(Pattern::mottled, {0.1F, 0.16F, 0.08F}, {0.38F, 0.42F, 0.26F}, 25)});
  b.scene.hills.push_back({700, 70, 60, b.material(Pattern::mottled, {0.2F, 0.22F, 0.24F}, {0.5F, 0.5F, 0.52F}, 120)});
}

void table(SceneBuilder& b, const Vector3d& foot, double yaw) {
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

void bookshelf(SceneBuilder& b, const Vector3d& foot, double yaw) {
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
void walls(SceneBuilder& b, double west, double east, double south, double north) {
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

}  // namespace ldp::scene
