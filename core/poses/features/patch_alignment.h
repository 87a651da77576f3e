// Square patches of a picture and their alignment to a fraction of a pixel (Lucas and Kanade 1981, inverse
// compositional as in Baker and Matthews 2004), zero-mean and of unit contrast so that exposure does not matter.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/plane.h"
#include "core/poses/features/feature_tuning.h"

namespace ldp::sfm {

constexpr int side(int radius) { return 2 * radius + 1; }
constexpr int samples(int radius) { return side(radius) * side(radius); }

template <int kRadius>
using Patch = std::array<float, static_cast<size_t>(samples(kRadius))>;

// Bilinear samples at centre + warp * (integer offsets); false when part of it is outside. Pixel centres at .5.
template <int kRadius>
bool sample(const GreyImage& image, const Eigen::Vector2d& centre, const Eigen::Matrix2d& warp, Patch<kRadius>& patch) {
  constexpr int kSide = side(kRadius);
  const double reach_x = kRadius * (std::abs(warp(0, 0)) + std::abs(warp(0, 1)));
  const double reach_y = kRadius * (std::abs(warp(1, 0)) + std::abs(warp(1, 1)));
  if (!(centre.x() - reach_x > 1 && centre.x() + reach_x < image.width - 1)) return false;
  if (!(centre.y() - reach_y > 1 && centre.y() + reach_y < image.height - 1)) return false;
  const Eigen::Matrix2f w = warp.cast<float>();
  size_t i = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    float x = static_cast<float>(centre.x()) - 0.5F - kRadius * w(0, 0) + static_cast<float>(dy) * w(0, 1);
    float y = static_cast<float>(centre.y()) - 0.5F - kRadius * w(1, 0) + static_cast<float>(dy) * w(1, 1);
    for (int dx = 0; dx < kSide; ++dx, x += w(0, 0), y += w(1, 0)) {
      const int column = static_cast<int>(x), row = static_cast<int>(y);
      const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
      const uint8_t *p = image.row(row) + column, *q = p + image.width;
      const float top = static_cast<float>(p[0]) + fx * static_cast<float>(p[1] - p[0]);
      const float bottom = static_cast<float>(q[0]) + fx * static_cast<float>(q[1] - q[0]);
      patch[i++] = top + fy * (bottom - top);
    }
  }
  return true;
}

// To mean 0 and length 1; false when there is next to nothing to see.
template <size_t kSamples>
bool normalise(std::array<float, kSamples>& patch, float* variance = nullptr) {
  constexpr float kCount = static_cast<float>(kSamples);
  float sum = 0, squares = 0;
  for (const float s : patch) sum += s;
  for (float& s : patch) {
    s -= sum / kCount;
    squares += s * s;
  }
  if (squares < kMinPatchContrast * kMinPatchContrast * kCount) return false;
  if (variance) *variance = squares / kCount;
  const float scale = 1 / std::sqrt(squares);
  for (float& s : patch) s *= scale;
  return true;
}

// What is looked for: the anchor's patch, its gradients, and their inverse normal matrix.
template <int kRadius>
struct Template {
  Patch<kRadius> patch, gradient_x, gradient_y;
  Eigen::Matrix2d inverse;
};

// Of a patch of mean 0 and length 1. None of an edge, which slides along itself.
template <int kRadius>
std::optional<Template<kRadius>> make_template(const Patch<kRadius>& patch) {
  constexpr int kSide = side(kRadius);
  Template<kRadius> t;
  t.patch = patch;
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto at = [&](int i, int j) {
        return t.patch[static_cast<size_t>(std::clamp(j, 0, kSide - 1) * kSide + std::clamp(i, 0, kSide - 1))];
      };
      const size_t i = static_cast<size_t>(y * kSide + x);
      t.gradient_x[i] = 0.5F * (at(x + 1, y) - at(x - 1, y));
      t.gradient_y[i] = 0.5F * (at(x, y + 1) - at(x, y - 1));
      const Eigen::Vector2d g(static_cast<double>(t.gradient_x[i]), static_cast<double>(t.gradient_y[i]));
      h += g * g.transpose();
    }
  }
  const double trace = h.trace(), determinant = h.determinant();
  if (determinant < kMinGradientRatio * (1 - kMinGradientRatio) * 0.25 * trace * trace) return std::nullopt;
  t.inverse = h.inverse();
  return t;
}

template <int kRadius>
std::optional<Template<kRadius>> make_template(const GreyImage& image, const Eigen::Vector2d& centre) {
  Patch<kRadius> patch;
  if (!sample<kRadius>(image, centre, Eigen::Matrix2d::Identity(), patch) || !normalise(patch)) return std::nullopt;
  return make_template<kRadius>(patch);
}

template <int kRadius>
struct Aligned {
  Eigen::Vector2d position;
  Patch<kRadius> patch;  // there, but for a step too small to count
  double correlation = 0;
  float variance = 0;  // of the patch, grey levels squared

  double residual_variance() const { return (1 - correlation) * static_cast<double>(variance); }
};

// What is left of the difference of two patches of length 1, taken for noise, moves the position by so much, pixels of
// the picture. Where near and far things cross, the patch changes from frame to frame; that shows here.
template <int kRadius>
double position_sigma(const Template<kRadius>& t, double correlation) {
  const double noise = std::sqrt(2 * std::max(0.0, 1 - correlation) / samples(kRadius));
  return noise * std::sqrt(0.5 * t.inverse.trace());
}

template <int kRadius>
std::optional<Aligned<kRadius>> align(const Template<kRadius>& t, const GreyImage& image,
                                      const Eigen::Vector2d& position, const Eigen::Matrix2d& warp) {
  Aligned<kRadius> there{position, {}};
  for (int round = 0; round < kMaxAlignmentIterations; ++round) {
    Patch<kRadius>& patch = there.patch;
    if (!sample<kRadius>(image, there.position, warp, patch) || !normalise(patch, &there.variance)) return std::nullopt;
    float gx = 0, gy = 0, product = 0;
    for (size_t i = 0; i < patch.size(); ++i) {
      const float difference = t.patch[i] - patch[i];
      gx += t.gradient_x[i] * difference;
      gy += t.gradient_y[i] * difference;
      product += t.patch[i] * patch[i];
    }
    there.correlation = static_cast<double>(product);
    const Eigen::Vector2d step = warp * (t.inverse * Eigen::Vector2d(static_cast<double>(gx), static_cast<double>(gy)));
    if (step.norm() > kMaxAlignmentStep_px) return std::nullopt;
    there.position += step;
    if (step.norm() < kAlignmentConverged_px) return there;
  }
  return std::nullopt;
}

}  // namespace ldp::sfm
