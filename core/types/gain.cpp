#include "gain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ldp {
namespace {

constexpr int kOne = 4096;
constexpr double kWhite = 255;

double brightened(double level, double gain) {
  constexpr double kShoulder = 208, kWidth = kWhite - kShoulder;
  const double beyond = gain * level - kShoulder, most = gain * kWhite - kShoulder;
  if (beyond <= 0) return gain * level;
  const double k = most / kWidth, t = beyond / most;
  return kShoulder + kWidth * k * t / (1 + (k - 1) * t);
}

double darkened(double level, double gain) {
  constexpr double kShoulder = 224;  // nearer to white: what is not clipped shall match what others show of it
  const double t = std::max(0.0, (level - kShoulder) / (kWhite - kShoulder));
  return level * (gain + (1 - gain) * t * t);
}

double evened(double level, double gain) { return gain >= 1 ? brightened(level, gain) : darkened(level, gain); }

// The level that becomes this one: curves rise, from 0 to white.
double uneven(double level, double gain) {
  double low = 0, high = kWhite;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (evened(middle, gain) < level ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

ExposureGain::ExposureGain(const Gain& gain) : ExposureGain(gain, evened) {}

ExposureGain ExposureGain::inverse(const Gain& gain) { return {gain, uneven}; }

ExposureGain::ExposureGain(const Gain& gain, Curve curve) {
  for (size_t c = 0; c < 3; ++c) {
    const auto g = static_cast<double>(gain[c]);
    for (size_t i = 0; i <= 256; ++i) {
      const double level = std::clamp(static_cast<double>(i), 1.0, kWhite);
      factor_q12_[c][i] = static_cast<int>(std::floor(curve(level, g) / level * kOne + 0.5));
    }
  }
}

std::array<int, 3> ExposureGain::operator()(const std::array<int, 3>& colour, int units) const {
  const int largest = std::max({colour[0], colour[1], colour[2]});
  const auto level = static_cast<size_t>(largest / units);
  const int above = largest % units;
  std::array<int, 3> result{};
  for (size_t c = 0; c < 3; ++c) {
    const int factor = factor_q12_[c][level] + (factor_q12_[c][level + 1] - factor_q12_[c][level]) * above / units;
    result[c] = static_cast<int>(int64_t{colour[c]} * factor / kOne);
  }
  return result;
}

}  // namespace ldp
