#include "core/photos/exposure_gain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/photos/exposure_tuning.h"

namespace ldp {

using namespace exposure;

namespace {

constexpr int kOne = 4096;

double brightened(double level, double gain) {
  constexpr double kWidth = kWhite - kBrightShoulder;
  const double beyond = gain * level - kBrightShoulder, most = gain * kWhite - kBrightShoulder;
  if (beyond <= 0) return gain * level;
  const double k = most / kWidth, t = beyond / most;
  return kBrightShoulder + kWidth * k * t / (1 + (k - 1) * t);
}

double darkened(double level, double gain) {
  const double t = std::max(0.0, (level - kDarkShoulder) / (kWhite - kDarkShoulder));
  return level * (gain + (1 - gain) * t * t);
}

double exposed(double level, double gain) { return gain >= 1 ? brightened(level, gain) : darkened(level, gain); }

}  // namespace

ExposureGain::ExposureGain(const Gain& gain) {
  for (size_t c = 0; c < 3; ++c) {
    const auto g = static_cast<double>(gain[c]);
    for (size_t i = 0; i <= 256; ++i) {
      const double level = std::clamp(static_cast<double>(i), 1.0, kWhite);
      factor_q12_[c][i] = static_cast<int>(std::floor(exposed(level, g) / level * kOne + 0.5));
    }
  }
}

int ExposureGain::factor(size_t channel, int level, int units) const {
  const auto& table = factor_q12_[channel];
  const auto whole = static_cast<size_t>(level / units);
  return table[whole] + (table[whole + 1] - table[whole]) * (level % units) / units;
}

std::array<int, 3> ExposureGain::operator()(const std::array<int, 3>& colour, int units) const {
  const int largest = std::max({colour[0], colour[1], colour[2]});
  std::array<int, 3> result{};
  for (size_t c = 0; c < 3; ++c) result[c] = static_cast<int>(int64_t{colour[c]} * factor(c, largest, units) / kOne);
  return result;
}

std::array<int, 3> ExposureGain::undone(const std::array<int, 3>& colour, int units) const {
  const auto before = [&](int largest) {
    std::array<int, 3> result{};
    for (size_t c = 0; c < 3; ++c)
      result[c] = static_cast<int>(int64_t{colour[c]} * kOne / std::max(1, factor(c, largest, units)));
    return result;
  };
  int low = 0, high = static_cast<int>(kWhite) * units;  // of the largest channel
  while (low < high) {
    const int middle = (low + high) / 2;
    const auto from = before(middle);
    if (std::max({from[0], from[1], from[2]}) > middle)
      low = middle + 1;
    else
      high = middle;
  }
  return before(low);
}

}  // namespace ldp
