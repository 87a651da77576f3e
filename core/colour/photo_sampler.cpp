#include "core/colour/photo_sampler.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/colour/colour_tuning.h"
#include "core/photos/catmull_rom.h"

namespace ldp::colour {
namespace {

constexpr int kSubpixels = 64;
constexpr int kWeightSum = 1024;

using Weights = std::array<int, 4>;

// Catmull-Rom weights at t / kSubpixels between the second and third of four samples; their sum is kWeightSum.
constexpr std::array<Weights, kSubpixels> cubic_weights() {
  std::array<Weights, kSubpixels> table{};
  constexpr int64_t kDivisor = catmull_rom_whole(kSubpixels) / kWeightSum;
  for (int t = 0; t < kSubpixels; ++t) {
    const std::array<int64_t, 4> exact = catmull_rom(t, kSubpixels);
    Weights& w = table[static_cast<size_t>(t)];
    for (size_t k = 0; k < 4; ++k) w[k] = static_cast<int>(exact[k] / kDivisor);
    w[2] = kWeightSum - w[0] - w[1] - w[3];
  }
  return table;
}

constexpr std::array<Weights, kSubpixels> kCubicWeights = cubic_weights();

Colour interpolate(const RgbImage& photo, const Eigen::Vector2d& position_px) {
  const auto fixed = [](double p, int size) {
    return static_cast<int>(std::floor((std::clamp(p, 0.0, static_cast<double>(size)) - 0.5) * kSubpixels + 0.5));
  };
  const int fx = fixed(position_px.x(), photo.width), fy = fixed(position_px.y(), photo.height);
  const int x0 = (fx + kSubpixels) / kSubpixels - 1, y0 = (fy + kSubpixels) / kSubpixels - 1;
  const Weights& wx = kCubicWeights[static_cast<size_t>(fx - x0 * kSubpixels)];
  const Weights& wy = kCubicWeights[static_cast<size_t>(fy - y0 * kSubpixels)];
  Colour sum{};
  for (int j = 0; j < 4; ++j) {
    const Rgb* row = photo.row(std::clamp(y0 + j - 1, 0, photo.height - 1));
    Colour line{};
    for (int i = 0; i < 4; ++i) {
      const Rgb c = row[std::clamp(x0 + i - 1, 0, photo.width - 1)];
      const int w = wx[static_cast<size_t>(i)];
      line[0] += w * c.r, line[1] += w * c.g, line[2] += w * c.b;
    }
    for (size_t k = 0; k < 3; ++k) sum[k] += wy[static_cast<size_t>(j)] * line[k];
  }
  constexpr int kDivisor = kWeightSum * kWeightSum / kColourSteps;
  for (int& channel : sum) channel = std::clamp((channel + kDivisor / 2) / kDivisor, 0, 255 * kColourSteps);
  return sum;
}

}  // namespace

PhotoSampler::PhotoSampler(const PanoramaGrid& grid, const Camera& camera, const Gain& gain,
                           const DisplayExposure* local)
    : grid_(grid),
      intrinsics_(camera.intrinsics),
      projection_(grid, camera),
      gain_(gain),
      everywhere_(gain),
      local_(local) {
  taps_ = std::clamp(static_cast<int>(std::lround(grid.v_pitch * intrinsics_.fy)), 1, 4);
  for (int i = 0; i < grid.width * taps_; ++i) headings_.push_back(heading(grid.theta((i + 0.5) / taps_)));
}

Colour PhotoSampler::sample(const RgbImage& photo, int x, int y, double w) const {
  Colour sum{};
  for (int j = 0; j < taps_; ++j)
    for (int i = 0; i < taps_; ++i) {
      const Heading u = headings_[static_cast<size_t>(x * taps_ + i)];
      const Colour c =
          interpolate(photo, project(intrinsics_, projection_.in_camera_axes(u, grid_.v(y + (j + 0.5) / taps_), w)));
      for (size_t k = 0; k < 3; ++k) sum[k] += c[k];
    }
  return mean(sum, taps_ * taps_, x, y);
}

std::optional<Colour> PhotoSampler::sample_if_inside(const RgbImage& photo, int x, int y, double w) const {
  const Heading u = headings_[static_cast<size_t>(x * taps_ + taps_ / 2)];
  const Eigen::Vector3d q = projection_.in_camera_axes(u, grid_.v(y + 0.5), w);
  if (q.z() < kLeastForward) return {};
  const Eigen::Vector2d p = project(intrinsics_, q);
  if (!(p.x() >= 0.5 && p.y() >= 0.5 && p.x() < photo.width - 0.5 && p.y() < photo.height - 0.5)) return {};
  const Colour colour = interpolate(photo, p);
  if (distrust(colour, x, y) > 0.5) return {};
  return taps_ == 1 ? mean(colour, 1, x, y) : sample(photo, x, y, w);
}

double PhotoSampler::distrust(const RgbImage& photo, int x, int y, double w) const {
  if (local_ == nullptr) return 0;
  const Heading u = headings_[static_cast<size_t>(x * taps_ + taps_ / 2)];
  const Eigen::Vector3d q = projection_.in_camera_axes(u, grid_.v(y + 0.5), w);
  return distrust(interpolate(photo, project(intrinsics_, q)), x, y);
}

double PhotoSampler::distrust(const Colour& colour, int x, int y) const {
  using namespace tuning;
  if (local_ == nullptr) return 0;
  const double level = *std::max_element(colour.begin(), colour.end()) / static_cast<double>(kColourSteps);
  if (level <= kUnclipped) return 0;
  const std::array<double, 3> factor = factor_at(x, y);
  const double darker = 1 - *std::min_element(factor.begin(), factor.end());
  return std::clamp((level - kUnclipped) / (kClipped - kUnclipped), 0.0, 1.0) *
         std::clamp(darker / kClippedDarker, 0.0, 1.0);
}

Colour PhotoSampler::mean(const Colour& sum, int count, int x, int y) const {
  Colour colour = exposed(sum, kColourSteps * count, x, y);
  for (int& channel : colour) channel /= count;
  return colour;
}

Colour PhotoSampler::exposed(const Colour& colour, int units, int x, int y) const {
  if (local_ == nullptr) return everywhere_(colour, units);
  return with_light(colour, units, factor_at(x, y), local_->response);
}

std::array<double, 3> PhotoSampler::factor_at(int x, int y) const {
  std::array<double, 3> factor = local_->factors.at((x + 0.5) / grid_.width, (y + 0.5) / grid_.height);
  for (size_t c = 0; c < 3; ++c) factor[c] *= static_cast<double>(gain_[c]);
  return factor;
}

}  // namespace ldp::colour
