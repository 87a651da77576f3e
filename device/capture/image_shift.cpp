#include "device/capture/image_shift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "device/capture/capture_tuning.h"

namespace ldp {
namespace {

// With the sums of its squares over the rectangle from the corner to each pixel.
struct Detail {
  Plane<int16_t> values;
  Plane<int64_t> squares;

  int64_t energy(int left, int top, int right, int bottom) const {
    return squares.at(right, bottom) - squares.at(left, bottom) - squares.at(right, top) + squares.at(left, top);
  }
};

GreyImage halve(const GreyImage& image) {
  GreyImage half(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const int sum = image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) + image.at(2 * x, 2 * y + 1) +
                      image.at(2 * x + 1, 2 * y + 1);
      half.at(x, y) = static_cast<uint8_t>(sum / 4);
    }
  }
  return half;
}

// What is left of an image without its slow changes (vignetting, sky to ground): minus the mean of a window around.
Plane<int16_t> without_slow_changes(const GreyImage& image) {
  Plane<int> sums(image.width + 1, image.height + 1, 0);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      sums.at(x + 1, y + 1) = image.at(x, y) + sums.at(x, y + 1) + sums.at(x + 1, y) - sums.at(x, y);
    }
  }
  Plane<int16_t> detail(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    const int top = std::max(0, y - kDetailReach_px), bottom = std::min(image.height, y + kDetailReach_px + 1);
    for (int x = 0; x < image.width; ++x) {
      const int left = std::max(0, x - kDetailReach_px), right = std::min(image.width, x + kDetailReach_px + 1);
      const int sum = sums.at(right, bottom) - sums.at(left, bottom) - sums.at(right, top) + sums.at(left, top);
      detail.at(x, y) = static_cast<int16_t>(image.at(x, y) - sum / ((right - left) * (bottom - top)));
    }
  }
  return detail;
}

Detail detail_of(const GreyImage& image) {
  Detail detail{without_slow_changes(image), Plane<int64_t>(image.width + 1, image.height + 1, 0)};
  for (int y = 0; y < image.height; ++y) {
    int64_t row = 0;
    for (int x = 0; x < image.width; ++x) {
      row += int64_t{detail.values.at(x, y)} * detail.values.at(x, y);
      detail.squares.at(x + 1, y + 1) = detail.squares.at(x + 1, y) + row;
    }
  }
  return detail;
}

// Correlation of first(x, y) with second(x + dx, y + dy) over their overlap.
double correlation(const Detail& first, const Detail& second, int dx, int dy) {
  const int left = std::max(0, -dx), right = std::min(first.values.width, second.values.width - dx);
  const int top = std::max(0, -dy), bottom = std::min(first.values.height, second.values.height - dy);
  if (right - left < kLeastOverlap_px || bottom - top < kLeastOverlap_px) return -1;
  int64_t product = 0;
  for (int y = top; y < bottom; ++y) {
    const int16_t* a = first.values.row(y);
    const int16_t* b = second.values.row(y + dy) + dx;
    int32_t row_product = 0;
    for (int x = left; x < right; ++x) row_product += a[x] * b[x];
    product += row_product;
  }
  const double energy = std::sqrt(static_cast<double>(first.energy(left, top, right, bottom)) *
                                  static_cast<double>(second.energy(left + dx, top + dy, right + dx, bottom + dy)));
  const double floor = kNoiseEnergy * (right - left) * (bottom - top);
  return static_cast<double>(product) / (energy + floor);
}

struct Search {
  int dx = 0, dy = 0;
  double match = -1;
};

Search best_in(const Detail& first, const Detail& second, std::array<int, 4> window) {
  Search best;
  for (int dy = window[2]; dy <= window[3]; ++dy) {
    for (int dx = window[0]; dx <= window[1]; ++dx) {
      const double match = correlation(first, second, dx, dy);
      if (match > best.match) best = {dx, dy, match};
    }
  }
  return best;
}

// Top of the parabola through three neighbouring correlations.
double top_of(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < -1e-9 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
}

}  // namespace

Shift estimate_shift(const GreyImage& first, const GreyImage& second, double reach) {
  if (first.width != second.width || first.height != second.height) {
    throw std::logic_error("thumbnails of one sweep must have one size");
  }
  const Detail fine_first = detail_of(first), fine_second = detail_of(second);
  const Detail coarse_first = detail_of(halve(first)), coarse_second = detail_of(halve(second));
  const int across = static_cast<int>(coarse_first.values.width * std::min(reach, kMostReach));
  const int down = std::max(2, static_cast<int>(coarse_first.values.height * kReachDown));
  const Search coarse = best_in(coarse_first, coarse_second, {-across, across, -down, down});
  const Search fine =
      best_in(fine_first, fine_second, {2 * coarse.dx - 2, 2 * coarse.dx + 2, 2 * coarse.dy - 2, 2 * coarse.dy + 2});
  const auto at = [&](int dx, int dy) { return correlation(fine_first, fine_second, fine.dx + dx, fine.dy + dy); };
  Shift shift;
  shift.dx_px = fine.dx + top_of(at(-1, 0), fine.match, at(1, 0));
  shift.dy_px = fine.dy + top_of(at(0, -1), fine.match, at(0, 1));
  shift.match = fine.match;
  return shift;
}

double mean_brightness(const GreyImage& image) {
  int64_t sum = 0;
  for (const uint8_t sample : image.samples) sum += sample;
  return image.empty() ? 0 : static_cast<double>(sum) / (255.0 * static_cast<double>(image.samples.size()));
}

}  // namespace ldp
