#include "core/photos/resize.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace ldp {
namespace {

// Positions are in units of 1 / target pixels, so that all weights are whole numbers and sum to the source's size.
struct Span {
  int begin = 0;
  std::vector<uint32_t> weights;
};

std::vector<Span> spans(int source, int target) {
  std::vector<Span> all(static_cast<size_t>(target));
  for (int i = 0; i < target; ++i) {
    const int64_t from = int64_t{i} * source, to = from + source;  // source pixel k covers [k, k + 1) * target
    Span& span = all[static_cast<size_t>(i)];
    span.begin = static_cast<int>(from / target);
    for (int64_t k = span.begin; k * target < to; ++k) {
      const int64_t covered = std::min(to, (k + 1) * target) - std::max(from, k * target);
      span.weights.push_back(static_cast<uint32_t>(covered));
    }
  }
  return all;
}

template <typename Pixel>
Plane<Pixel> resized(const Plane<Pixel>& source, int width, int height) {
  if (width < 1 || height < 1 || width > source.width || height > source.height) {
    throw std::logic_error("resize_by_area: the new size must lie between 1x1 and the source's");
  }
  if (width == source.width && height == source.height) return source;
  constexpr size_t kChannels = sizeof(Pixel);  // of 8 bits
  const auto bytes = [](auto* pixels) { return reinterpret_cast<const uint8_t*>(pixels); };
  const std::vector<Span> columns = spans(source.width, width), rows = spans(source.height, height);
  const uint64_t area = static_cast<uint64_t>(source.width) * static_cast<uint64_t>(source.height);
  Plane<Pixel> result(width, height);
  std::vector<std::array<uint64_t, kChannels>> line(static_cast<size_t>(width));
  for (int y = 0; y < height; ++y) {
    std::fill(line.begin(), line.end(), std::array<uint64_t, kChannels>{});
    const Span& row = rows[static_cast<size_t>(y)];
    for (size_t j = 0; j < row.weights.size(); ++j) {
      const uint8_t* from = bytes(source.row(row.begin + static_cast<int>(j)));
      for (int x = 0; x < width; ++x) {
        const Span& column = columns[static_cast<size_t>(x)];
        const uint8_t* pixel = from + static_cast<size_t>(column.begin) * kChannels;
        for (const uint32_t weight : column.weights) {
          for (size_t c = 0; c < kChannels; ++c)
            line[static_cast<size_t>(x)][c] += uint64_t{row.weights[j]} * weight * *pixel++;
        }
      }
    }
    uint8_t* to = reinterpret_cast<uint8_t*>(result.row(y));
    for (const auto& sums : line) {
      for (const uint64_t sum : sums) *to++ = static_cast<uint8_t>((sum + area / 2) / area);
    }
  }
  return result;
}

}  // namespace

RgbImage resize_by_area(const RgbImage& source, int width, int height) { return resized(source, width, height); }
GreyImage resize_by_area(const GreyImage& source, int width, int height) { return resized(source, width, height); }

}  // namespace ldp
