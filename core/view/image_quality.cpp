#include "core/view/image_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace ldp {
namespace {

constexpr int kReach = 5;
constexpr double kDeviation = 1.5;
constexpr uint8_t kHoleGrey = 127;
constexpr uint8_t kOpaque = 128;

using Kernel = std::array<double, 2 * kReach + 1>;

Kernel gaussian() {
  Kernel kernel{};
  double sum = 0;
  for (int i = -kReach; i <= kReach; ++i) {
    kernel[static_cast<size_t>(i + kReach)] = std::exp(-i * i / (2 * kDeviation * kDeviation));
    sum += kernel[static_cast<size_t>(i + kReach)];
  }
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

// Mirrored about the outermost samples.
int mirrored(int i, int count) {
  if (count == 1) return 0;
  const int period = 2 * (count - 1);
  const int within = std::abs(i) % period;
  return within < count ? within : period - within;
}

Plane<double> blurred(const Plane<double>& a) {
  static const Kernel kernel = gaussian();
  Plane<double> down(a.width, a.height), across(a.width, a.height);
  for (int y = 0; y < a.height; ++y) {
    for (int k = -kReach; k <= kReach; ++k) {
      const double* row = a.row(mirrored(y + k, a.height));
      const double weight = kernel[static_cast<size_t>(k + kReach)];
      for (int x = 0; x < a.width; ++x) down.at(x, y) += weight * row[x];
    }
  }
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      double sum = 0;
      for (int k = -kReach; k <= kReach; ++k)
        sum += kernel[static_cast<size_t>(k + kReach)] * down.at(mirrored(x + k, a.width), y);
      across.at(x, y) = sum;
    }
  }
  return across;
}

Plane<double> product(const Plane<double>& a, const Plane<double>& b) {
  Plane<double> result = a;
  for (size_t i = 0; i < result.samples.size(); ++i) result.samples[i] *= b.samples[i];
  return result;
}

Plane<double> grey(const RgbImage& image) {
  Plane<double> result(image.width, image.height);
  for (size_t i = 0; i < image.samples.size(); ++i) {
    const Rgb& p = image.samples[i];
    result.samples[i] = 0.299 * p.r + 0.587 * p.g + 0.114 * p.b;
  }
  return result;
}

std::array<double, 3> channels(const Rgb& p) {
  return {static_cast<double>(p.r), static_cast<double>(p.g), static_cast<double>(p.b)};
}

double psnr_of(double squared_error) { return 10 * std::log10(255.0 * 255.0 / std::max(squared_error, 1e-6)); }

// Factors that bring the covered pixels of the view closest to the truth.
std::array<double, 3> best_gains(const RgbImage& view, const std::vector<bool>& covered, const RgbImage& truth) {
  std::array<double, 3> cross{}, own{}, gains{1, 1, 1};
  for (size_t i = 0; i < truth.samples.size(); ++i) {
    if (!covered[i]) continue;
    const auto v = channels(view.samples[i]), t = channels(truth.samples[i]);
    for (size_t c = 0; c < 3; ++c) {
      cross[c] += v[c] * t[c];
      own[c] += v[c] * v[c];
    }
  }
  for (size_t c = 0; c < 3; ++c)
    if (own[c] > 0) gains[c] = cross[c] / own[c];
  return gains;
}

}  // namespace

double ssim(const Plane<double>& a, const Plane<double>& b) {
  constexpr double kC1 = (0.01 * 255) * (0.01 * 255), kC2 = (0.03 * 255) * (0.03 * 255);
  const Plane<double> mean_a = blurred(a), mean_b = blurred(b);
  const Plane<double> square_a = blurred(product(a, a)), square_b = blurred(product(b, b)),
                      cross = blurred(product(a, b));
  double sum = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    const double ma = mean_a.samples[i], mb = mean_b.samples[i];
    const double va = square_a.samples[i] - ma * ma, vb = square_b.samples[i] - mb * mb,
                 cov = cross.samples[i] - ma * mb;
    sum += ((2 * ma * mb + kC1) * (2 * cov + kC2)) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
  }
  return sum / static_cast<double>(a.samples.size());
}

ViewQuality view_quality(const RgbImage& view, const Plane<uint8_t>& alpha, const RgbImage& truth) {
  const bool alpha_fits = alpha.empty() || (alpha.width == truth.width && alpha.height == truth.height);
  if (view.width != truth.width || view.height != truth.height || !alpha_fits || truth.empty()) {
    throw std::logic_error("view_quality: the view, its alpha and the true picture must be of one size");
  }
  const size_t pixels = truth.samples.size();
  RgbImage filled = view;
  std::vector<bool> covered(pixels, true);
  size_t holes = 0;
  for (size_t i = 0; i < pixels; ++i) {
    if (alpha.empty() || alpha.samples[i] >= kOpaque) continue;
    covered[i] = false;
    filled.samples[i] = {kHoleGrey, kHoleGrey, kHoleGrey};
    ++holes;
  }
  const std::array<double, 3> gains = best_gains(filled, covered, truth);
  double all = 0, seen = 0, matched = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const auto v = channels(filled.samples[i]), t = channels(truth.samples[i]);
    for (size_t c = 0; c < 3; ++c) {
      const double error = (v[c] - t[c]) * (v[c] - t[c]), level = covered[i] ? std::min(255.0, gains[c] * v[c]) : v[c];
      all += error;
      seen += covered[i] ? error : 0;
      matched += (level - t[c]) * (level - t[c]);
    }
  }
  const double samples = 3.0 * static_cast<double>(pixels);
  ViewQuality quality;
  quality.psnr_db = psnr_of(all / samples);
  quality.psnr_matched_db = psnr_of(matched / samples);
  if (holes < pixels) quality.psnr_covered_db = psnr_of(seen / (3.0 * static_cast<double>(pixels - holes)));
  quality.ssim = ssim(grey(filled), grey(truth));
  quality.holes = static_cast<double>(holes) / static_cast<double>(pixels);
  return quality;
}

}  // namespace ldp
