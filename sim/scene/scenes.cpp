#include "sim/scene/scenes.h"

#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "sim/scene/random.h"
#include "sim/scene/scene_builder.h"
#include "sim/scene/scene_things.h"

namespace ldp {

using namespace scene;

namespace {

SceneDescription garden(uint32_t seed) {
  SceneBuilder b(seed);
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
  SceneBuilder b(seed);
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

SceneDescription room(uint32_t seed) {
  SceneBuilder b(seed);
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
  SceneBuilder b(seed);
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
  SceneBuilder b(seed);
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
  SceneBuilder b(seed);
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

SceneDescription railings(uint32_t seed) {
  SceneBuilder b(seed);
  b.scene.ground = b.material(Pattern::bricks, {0.24F, 0.22F, 0.2F}, {0.6F, 0.57F, 0.52F}, 0.5);
  b.scene.ground.accent = {0.16F, 0.15F, 0.14F};
  countryside(b);
  houses(b, 12, 12, 18);
  railing(b, 4.4, 0, kFullTurn, 0.14);
  constexpr int kPosts = 8;
  const Material metal = b.metal();
  for (int i = 0; i < kPosts; ++i) {
    const double angle = kFullTurn * i / kPosts, next = kFullTurn * (i + 1) / kPosts;
    b.rod(polar(angle, 5.5, 0), polar(angle, 5.5, 3.3), 0.04, metal);
    for (const double height : {2.3, 2.7, 3.1}) wire(b, polar(angle, 5.5, height), polar(next, 5.5, height), metal);
  }
  for (int i = 0; i < 6; ++i) {
    const double angle = kFullTurn * (i + b.random.uniform(0.1, 0.5)) / 6;
    tree(b, polar(angle, b.random.uniform(6.5, 9), 0), b.random.uniform(3, 4.5), 60);
    planter(b, polar(angle + 0.35, b.random.uniform(2.2, 3), 0), 0.7, 30);
    for (int k = 0; k < 3; ++k)
      tuft(b, polar(angle + 0.5 + 0.12 * k, b.random.uniform(1.8, 3.2), 0), b.random.uniform(1.2, 1.8), 14);
  }
  return b.scene;
}

const std::map<std::string, std::function<SceneDescription(uint32_t)>>& makers() {
  static const std::map<std::string, std::function<SceneDescription(uint32_t)>> all = {
      {"courtyard", courtyard}, {"figures", figures}, {"garden", garden},  {"railings", railings},
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
