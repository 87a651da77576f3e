#include "noise.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "resample.h"

namespace ldp {
namespace {

constexpr int kCellPx = 16;
constexpr size_t kPlainest = 20;                                        // one in so many cells
constexpr int kDark = 12 * kSampleScale, kBright = 243 * kSampleScale;  // beyond, noise is clipped

int second_derivative(const uint16_t* above, const uint16_t* here, const uint16_t* below) {
  const auto along = [](const uint16_t* p) { return p[-1] - 2 * p[0] + p[1]; };
  return along(above) - 2 * along(here) + along(below);
}

// Sum of absolute second derivatives of a cell; negative where it is clipped.
int roughness(const Plane<uint16_t>& grey, int x0, int y0) {
  int sum = 0;
  for (int y = y0; y < y0 + kCellPx; ++y)
    for (int x = x0; x < x0 + kCellPx; ++x) {
      const uint16_t* here = grey.row(y) + x;
      if (*here < kDark || *here > kBright) return -1;
      sum += std::abs(second_derivative(grey.row(y - 1) + x, here, grey.row(y + 1) + x));
    }
  return sum;
}

}  // namespace

float noise_of(const Plane<uint16_t>& grey) {
  std::vector<int> cells;
  for (int y = 1; y + kCellPx < grey.height; y += kCellPx)
    for (int x = 1; x + kCellPx < grey.width; x += kCellPx)
      if (const int r = roughness(grey, x, y); r >= 0) cells.push_back(r);
  if (cells.empty()) return 0;
  const auto plain = cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / kPlainest);
  std::nth_element(cells.begin(), plain, cells.end());
  constexpr double kWeights = 6;  // root of the sum of the derivative's squared weights
  const double mean = *plain / static_cast<double>(kCellPx * kCellPx * kSampleScale);
  return static_cast<float>(std::sqrt(std::numbers::pi / 2) * mean / kWeights);
}

}  // namespace ldp
