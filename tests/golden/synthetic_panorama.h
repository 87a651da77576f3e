// Small layered panoramas made by integer arithmetic alone, the same on every machine: slanted ground, a far wall with
// texture, near discs and posts, and behind them second and third layers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>

#include "core/geometry/disparity.h"
#include "core/panorama/panorama.h"

namespace ldp {

struct SyntheticOptions {
  int width = 200, height = 90;
  int block_px = 0;
  int layers = 3;
  bool alpha = false;
  Rays rays = Rays::pushbroom;
  bool wraps = false;
  bool local_exposure = false;
};

namespace synthetic {

inline uint32_t hash(uint32_t a, uint32_t b, uint32_t c) {
  uint32_t h = a * 0x9E3779B1U ^ b * 0x85EBCA77U ^ c * 0xC2B2AE3DU;
  h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
  return h ^ (h >> 12);
}

// Disparity of the scene without its discs and posts: a far wall above, ground that comes nearer below.
inline int background(int x, int y, int height) {
  const int horizon = height / 2;
  const int wall = 300 + (x * 7 / 11) % 400;
  return y < horizon ? wall : std::min(wall + (y - horizon) * 2400 / height, kDisparitySteps);
}

// Which of a row of discs covers the pixel: its distance inside, or 0.
inline int disc(int x, int y, int height, int shift) {
  const int period = 64;
  const int cx = (x + shift) / period * period + period / 2 - shift;
  const int radius = 9 + static_cast<int>(hash(static_cast<uint32_t>(cx + 1000), 7, 1) % 12);
  const int dx = x - cx;
  const int dy = y - height / 2 - static_cast<int>(hash(static_cast<uint32_t>(cx + 1000), 3, 2) % 20);
  const int inside = radius * radius - dx * dx - dy * dy;
  return std::max(0, inside);
}

inline Rgb colour(int x, int y, int disparity, uint32_t seed) {
  const uint32_t grain = hash(static_cast<uint32_t>(x), static_cast<uint32_t>(y), seed) % 12;
  const auto clamp = [](int v) { return static_cast<uint8_t>(std::clamp(v, 0, 255)); };
  return {clamp(disparity / 16 + static_cast<int>(grain)), clamp(90 + x / 3 % 80 + static_cast<int>(grain)),
          clamp(200 - y + static_cast<int>(grain))};
}

}  // namespace synthetic

inline Layer synthetic_layer(const SyntheticOptions& options, int index) {
  DisparityMap disparity(options.width, options.height, kNoDisparity);
  Layer layer;
  layer.coverage = Plane<uint8_t>(options.width, options.height);
  layer.colour = RgbImage(options.width, options.height);
  if (options.alpha) layer.alpha = Plane<uint8_t>(options.width, options.height);
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      const int far = synthetic::background(x, y, options.height);
      const int near = synthetic::disc(x, y, options.height, 0);
      const int middle = synthetic::disc(x, y, options.height, 20);
      int d = -1;
      if (index == 0) d = near > 0 ? 3000 + near : middle > 0 ? 1900 + middle / 2 : far;
      if (index == 1 && near > 0) d = middle > 0 ? 1900 + middle / 2 : far;
      if (index == 2 && near > 0 && middle > 0) d = far;
      if (index >= 3 && near > 100 && middle > 40) d = far / 2;
      if (d < 0) continue;
      disparity.at(x, y) = static_cast<uint16_t>(std::min(d, kDisparitySteps));
      layer.coverage.at(x, y) = 1;
      layer.colour.at(x, y) = synthetic::colour(x, y, d, static_cast<uint32_t>(index));
      if (options.alpha) layer.alpha.at(x, y) = static_cast<uint8_t>(near > 0 ? std::min(255, 40 + near * 4) : 255);
    }
  layer.depth = encode_depth(disparity, options.block_px);
  return layer;
}

// Of half to twice the light, with tints; light rises with a level's square.
inline DisplayExposure synthetic_exposure(bool wraps) {
  DisplayExposure exposure;
  for (uint32_t i = 0; i < ResponseCurve::kKnots; ++i) exposure.response.light[i] = 5 * i * i;
  exposure.factors.wraps = wraps;
  exposure.factors.nodes = {7, 3};
  uint32_t i = 0;
  for (auto& node : exposure.factors.nodes.samples)
    for (uint16_t& factor : node) factor = static_cast<uint16_t>(2048 + synthetic::hash(++i, 5, 9) % 6145);
  return exposure;
}

inline LayeredPanorama synthetic_panorama(const SyntheticOptions& options) {
  LayeredPanorama panorama;
  PanoramaGrid& grid = panorama.grid;
  grid.width = options.width;
  grid.height = options.height;
  grid.rays = options.rays;
  grid.wraps = options.wraps;
  grid.arc.closed = options.wraps;
  grid.arc.centre = {0.5, -0.25, 1.625};
  grid.arc.radius = 0.65;
  grid.theta_pitch = options.wraps ? 2 * std::numbers::pi / options.width : 1.0 / 64;
  grid.theta_left = 1.75;
  grid.arc.theta_end = 1.5;
  grid.arc.theta_begin = -1.0;
  if (options.wraps) grid.arc.theta_end = grid.arc.theta_begin + 2 * std::numbers::pi;
  grid.v_pitch = 1.0 / 64;
  grid.v_top = 0.6875;
  grid.w_far = 0;
  grid.w_near = 1.25;
  panorama.limits = {0.25, 1.0, 0.125};
  if (options.local_exposure) panorama.exposure = synthetic_exposure(options.wraps);
  for (int i = 0; i < options.layers; ++i) panorama.layers.push_back(synthetic_layer(options, i));
  for (int i = 0; i < 3; ++i) {
    Camera camera;
    camera.name = "frame_00" + std::to_string(i) + ".jpg";
    camera.intrinsics = {80, 60, 64, 64.5, 40, 30, -0.125, 0.0625, 0, 0};
    camera.pose.centre = {0.5 + i, 0.25, 1.5};
    panorama.cameras.push_back(camera);
  }
  panorama.quality = {{"coverage_percent", 97.5}, {"psnr_leave_one_out_db", 24.25}};
  panorama.metadata = {{"captured_utc", "2026-01-02T03:04:05Z"}, {"device", "synthetic"}, {"unit", "metre"}};
  return panorama;
}

}  // namespace ldp
