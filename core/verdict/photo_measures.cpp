#include "core/verdict/photo_measures.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

namespace ldp {
namespace {

constexpr int kLeastSide = 16;
constexpr int kTap = 4;  // pixels to either side of the blur that a picture is compared with
constexpr int kBlock = 8;
constexpr double kSmoothest = 0.01;  // share of the blocks: foliage leaves little else plain
constexpr double kOfAll = 0.7;       // of the noise of all blocks that the smoothest hundredth has by chance
constexpr int kClipped = 4;          // levels from black or white, where noise is cut off

Plane<int> grey_of(const RgbImage& photo) {
  Plane<int> grey(photo.width, photo.height);
  for (size_t i = 0; i < grey.samples.size(); ++i) {
    const Rgb& p = photo.samples[i];
    grey.samples[i] = (77 * p.r + 150 * p.g + 29 * p.b + 128) >> 8;
  }
  return grey;
}

// Differences of one line of samples, `step` apart, and how many of them another blur takes away.
struct Differences {
  int64_t all = 0, taken = 0;
  int64_t squares = 0, count = 0;

  void add_line(const int* samples, int count_of_samples, std::ptrdiff_t step) {
    constexpr int kWidth = 2 * kTap + 1;
    for (int i = kTap + 1; i + kTap < count_of_samples; ++i) {
      const int* at = samples + i * step;
      const int sharp = kWidth * std::abs(at[0] - at[-step]);
      const int blurred = std::abs(at[kTap * step] - at[-(kTap + 1) * step]);
      all += sharp;
      taken += std::max(0, sharp - blurred);
      squares += int64_t{at[0] - at[-step]} * (at[0] - at[-step]);
      ++count;
    }
  }
  double left() const { return all > 0 ? 1 - static_cast<double>(taken) / static_cast<double>(all) : 0; }
};

// Mean absolute second difference of a block; -1 where it is clipped.
int roughness(const Plane<int>& grey, int left, int top) {
  int sum = 0;
  for (int y = top; y < top + kBlock; ++y) {
    for (int x = left; x < left + kBlock; ++x) {
      if (grey.at(x, y) <= kClipped || grey.at(x, y) >= 255 - kClipped) return -1;
      const int *up = grey.row(y - 1) + x, *on = grey.row(y) + x, *down = grey.row(y + 1) + x;
      sum +=
          std::abs(up[-1] - 2 * up[0] + up[1] - 2 * on[-1] + 4 * on[0] - 2 * on[1] + down[-1] - 2 * down[0] + down[1]);
    }
  }
  return sum;
}

double noise_of(const Plane<int>& grey) {
  std::vector<int> sums;
  for (int y = 1; y + kBlock < grey.height; y += kBlock) {
    for (int x = 1; x + kBlock < grey.width; x += kBlock) {
      if (const int sum = roughness(grey, x, y); sum >= 0) sums.push_back(sum);
    }
  }
  if (sums.empty()) return 0;
  const auto at = sums.begin() + static_cast<std::ptrdiff_t>(kSmoothest * static_cast<double>(sums.size()));
  std::nth_element(sums.begin(), at, sums.end());
  return std::sqrt(std::numbers::pi / 2) / 6 / kOfAll * *at / (kBlock * kBlock);
}

}  // namespace

PhotoMeasures measure(const RgbImage& photo) {
  PhotoMeasures measures;
  if (photo.width < kLeastSide || photo.height < kLeastSide) return measures;
  const Plane<int> grey = grey_of(photo);
  int64_t sum = 0;
  for (const int value : grey.samples) sum += value;
  measures.brightness = static_cast<double>(sum) / static_cast<double>(grey.samples.size());
  Differences across, down;
  for (int y = 0; y < grey.height; ++y) across.add_line(grey.row(y), grey.width, 1);
  for (int x = 0; x < grey.width; ++x) down.add_line(grey.row(0) + x, grey.height, grey.width);
  measures.blur_x = across.left();
  measures.blur_y = down.left();
  measures.noise = noise_of(grey);
  measures.detail = std::sqrt(static_cast<double>(across.squares + down.squares) /
                              static_cast<double>(std::max<int64_t>(1, across.count + down.count)));
  return measures;
}

}  // namespace ldp
