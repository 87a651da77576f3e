#include "sim/scene/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/scene/random.h"

namespace ldp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kLatticeBits = 6;
constexpr int kLattice = 1 << kLatticeBits;
constexpr int kMask = kLattice - 1;

using Lattice = std::array<uint8_t, size_t{1} << (3 * kLatticeBits)>;

const Lattice& lattice() {
  static const Lattice values = [] {
    Lattice filled{};
    Random random(20070617);
    for (uint8_t& value : filled) value = static_cast<uint8_t>(random.bits() & 255);
    return filled;
  }();
  return values;
}

struct Cell {
  int index;
  float fade;  // smooth weight of the next lattice point
};

Cell cell_of(double x) {
  const double floor = std::floor(x);
  const auto fraction = static_cast<float>(x - floor);
  return {static_cast<int>(static_cast<int64_t>(floor) & kMask), fraction * fraction * (3 - 2 * fraction)};
}

float mix(float a, float b, float t) { return a + (b - a) * t; }
Vector3f mix(const Vector3f& a, const Vector3f& b, float t) { return a + (b - a) * t; }

// Value noise, 0 .. 1, period 64.
float value_noise(const Vector3d& p) {
  const Lattice& values = lattice();
  const Cell x = cell_of(p.x()), y = cell_of(p.y()), z = cell_of(p.z());
  const int x1 = (x.index + 1) & kMask, y1 = (y.index + 1) & kMask, z1 = (z.index + 1) & kMask;
  const auto along_x = [&](int yi, int zi) {
    const size_t row = (static_cast<size_t>(zi) << (2 * kLatticeBits)) | (static_cast<size_t>(yi) << kLatticeBits);
    return mix(values[row | static_cast<size_t>(x.index)], values[row | static_cast<size_t>(x1)], x.fade);
  };
  const float front = mix(along_x(y.index, z.index), along_x(y1, z.index), y.fade);
  const float back = mix(along_x(y.index, z1), along_x(y1, z1), y.fade);
  return mix(front, back, z.fade) * (1.0F / 255);
}

float hash01(int64_t a, int64_t b, uint32_t seed) {
  const uint64_t key = mix_bits(static_cast<uint64_t>(a) * 0x1F123BB5ULL ^ mix_bits(static_cast<uint64_t>(b) + seed));
  return static_cast<float>(key >> 40) * 0x1.0p-24F;
}

// 1 while a feature of `size` spans several pixels, 0 when it is smaller than two.
float visibility_of(double size, double pixel) {
  return static_cast<float>(std::clamp((size / pixel - 2) / 3, 0.0, 1.0));
}

Vector3f mottled(const Material& m, const TexturePoint& p) {
  const float noise = fractal_noise(p.local, m.size_m, p.pixel_m, m.seed);
  return mix(m.dark, m.light, std::clamp(0.5F + 0.75F * noise, 0.0F, 1.0F));
}

// Courses of blocks with joints, each block of its own shade. `stagger` shifts every other course by half a block.
Vector3f blocks(const Material& m, const TexturePoint& p, const Vector2d& block, double joint) {
  const auto course = static_cast<int64_t>(std::floor(p.face.y() / block.y()));
  const double along = p.face.x() / block.x() + ((course & 1) != 0 ? 0.5 : 0.0);
  const auto column = static_cast<int64_t>(std::floor(along));
  const double from_side =
      std::min(along - static_cast<double>(column), static_cast<double>(column) + 1 - along) * block.x();
  const double rise = p.face.y() / block.y() - static_cast<double>(course);
  const double from_bed = std::min(rise, 1 - rise) * block.y();
  const float grain = 0.5F + 0.6F * fractal_noise(p.local, 0.5 * block.y(), p.pixel_m, m.seed);
  const float shade = std::clamp(0.55F * hash01(course, column, m.seed) + 0.45F * grain, 0.0F, 1.0F);
  const float shown = visibility_of(block.y(), p.pixel_m);
  const auto joint_share = static_cast<float>(std::min(1.0, joint / block.x() + joint / block.y()));
  const Vector3f mean = mix(mix(m.dark, m.light, mix(0.5F, shade, shown)), m.accent, joint_share);
  const bool in_joint = std::min(from_side, from_bed) < 0.5 * joint;
  const Vector3f sharp = in_joint ? Vector3f(m.accent * (0.8F + 0.4F * grain)) : mix(m.dark, m.light, shade);
  return mix(mean, sharp, shown);
}

Vector3f checks(const Material& m, const TexturePoint& p) {
  const auto a = static_cast<int64_t>(std::floor(p.face.x() / m.size_m)),
             b = static_cast<int64_t>(std::floor(p.face.y() / m.size_m));
  const float grain = 0.35F * fractal_noise(p.local, 0.4 * m.size_m, p.pixel_m, m.seed);
  const float sharp = ((a + b) & 1) != 0 ? 0.85F : 0.15F;
  const float tone = mix(0.5F, sharp, visibility_of(m.size_m, p.pixel_m)) + grain;
  return mix(m.dark, m.light, std::clamp(tone, 0.0F, 1.0F));
}

Vector3f planks(const Material& m, const TexturePoint& p) {
  const auto plank = static_cast<int64_t>(std::floor(p.face.y() / m.size_m));
  const float shift = hash01(plank, 7, m.seed);
  const Vector3d stretched = {0.12 * p.face.x() + 3 * shift, p.face.y(), 5 * shift};
  const float grain = fractal_noise(stretched, 0.4 * m.size_m, p.pixel_m, m.seed);
  const double within = p.face.y() / m.size_m - static_cast<double>(plank);
  const float shown = visibility_of(m.size_m, p.pixel_m);
  const Vector3f wood =
      mix(m.dark, m.light, std::clamp(0.5F + 0.3F * (shift - 0.5F) * shown + 0.5F * grain, 0.0F, 1.0F));
  return within < 0.04 ? Vector3f(wood * mix(1.0F, 0.35F, shown)) : wood;
}

// The face's first axis runs along the mid rib.
Vector3f leaf(const Material& m, const TexturePoint& p) {
  const float hue = hash01(m.seed, 3, 11);
  const double vein = std::abs(std::remainder(p.face.x() + 0.6 * std::abs(p.face.y()), 0.25 * m.size_m));
  const bool on_rib = std::abs(p.face.y()) < 0.02 * m.size_m;
  const float line = on_rib ? 0.6F : vein < 0.012 * m.size_m ? 0.3F : 0.0F;
  const float noise = fractal_noise(p.local, m.size_m, p.pixel_m, m.seed);
  const Vector3f green = mix(m.dark, m.light, std::clamp(0.15F + 0.6F * hue + 0.5F * noise, 0.0F, 1.0F));
  return mix(green, m.accent, line * visibility_of(0.08 * m.size_m, p.pixel_m));
}

Vector3f cloth(const Material& m, const TexturePoint& p) {
  const float stripe = static_cast<float>(std::sin(2 * std::numbers::pi * p.local.z() / m.size_m));
  const float noise = fractal_noise(p.local, 1.5 * m.size_m, p.pixel_m, m.seed);
  const float tone = 0.5F + 0.25F * stripe * visibility_of(m.size_m, p.pixel_m) + 0.6F * noise;
  return mix(m.dark, m.light, std::clamp(tone, 0.0F, 1.0F));
}

// Plaster with a grid of windows.
Vector3f facade(const Material& m, const TexturePoint& p) {
  const double cell = m.size_m, u = p.face.x() / cell, v = p.face.y() / (1.15 * cell);
  const auto column = static_cast<int64_t>(std::floor(u)), row = static_cast<int64_t>(std::floor(v));
  const double s = std::abs(u - static_cast<double>(column) - 0.5), t = std::abs(v - static_cast<double>(row) - 0.55);
  const float noise = fractal_noise(p.local, 0.7 * cell, p.pixel_m, m.seed);
  Vector3f plaster = mix(m.dark, m.light, std::clamp(0.5F + 0.5F * noise, 0.0F, 1.0F));
  if (s < 0.2 && t < 0.27) {
    const bool bar = s < 0.015 || std::abs(t - 0.05) < 0.012 || s > 0.18 || t > 0.25;
    if (bar) return {0.55F, 0.53F, 0.48F};
    return m.accent * (0.35F + 0.9F * hash01(column, row, m.seed)) * (1 + 0.3F * noise);
  }
  return plaster;
}

// A painting: broad strokes of several colours inside a frame.
Vector3f picture(const Material& m, const TexturePoint& p) {
  const float a = fractal_noise(p.local, m.size_m, p.pixel_m, m.seed);
  const float b = fractal_noise(p.local, 0.6 * m.size_m, p.pixel_m, m.seed + 101);
  const Vector3f base = mix(m.dark, m.light, std::clamp(0.5F + 0.9F * a, 0.0F, 1.0F));
  return mix(base, m.accent, std::clamp(1.6F * b - 0.1F, 0.0F, 1.0F));
}

}  // namespace

float fractal_noise(const Vector3d& point, double wavelength_m, double pixel_m, uint32_t seed) {
  constexpr int kOctaves = 7;
  const double shift = static_cast<double>(seed & 1023) * 0.61803;
  float sum = 0, amplitude = 1;
  double wavelength = wavelength_m;
  for (int octave = 0; octave < kOctaves; ++octave) {
    const double fade = std::clamp((wavelength / pixel_m - 2.0) / 2.0, 0.0, 1.0);
    if (fade <= 0) break;
    const Vector3d at = point / wavelength + Vector3d(shift, 1.7 * shift + 13.1 * octave, 2.3 * shift + 5.7 * octave);
    sum += amplitude * static_cast<float>(fade) * (value_noise(at) - 0.5F);
    amplitude *= 0.82F;
    wavelength *= 0.5;
  }
  return 0.95F * sum;
}

Vector3f reflectance(const Material& m, const TexturePoint& p) {
  switch (m.pattern) {
    case Pattern::plain:
      return m.light;
    case Pattern::mottled:
      return mottled(m, p);
    case Pattern::bricks:
      return blocks(m, p, {m.size_m, m.size_m / 3}, 0.05 * m.size_m);
    case Pattern::checks:
      return checks(m, p);
    case Pattern::planks:
      return planks(m, p);
    case Pattern::leaf:
      return leaf(m, p);
    case Pattern::cloth:
      return cloth(m, p);
    case Pattern::facade:
      return facade(m, p);
    case Pattern::shingles:
      return blocks(m, p, {m.size_m, 0.8 * m.size_m}, 0.04 * m.size_m);
    case Pattern::picture:
      return picture(m, p);
  }
  return m.light;
}

}  // namespace ldp
