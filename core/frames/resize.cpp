#include "resize.h"

#include <algorithm>
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

struct Sums {
  uint64_t r = 0, g = 0, b = 0;
};

}  // namespace

RgbImage resize_by_area(const RgbImage& source, int width, int height) {
  if (width < 1 || height < 1 || width > source.width || height > source.height) {
    throw std::logic_error("resize_by_area: the new size must lie between 1x1 and the source's");
  }
  if (width == source.width && height == source.height) return source;
  const std::vector<Span> columns = spans(source.width, width), rows = spans(source.height, height);
  const uint64_t area = static_cast<uint64_t>(source.width) * static_cast<uint64_t>(source.height);
  RgbImage result(width, height);
  std::vector<Sums> line(static_cast<size_t>(width));
  for (int y = 0; y < height; ++y) {
    std::fill(line.begin(), line.end(), Sums{});
    const Span& row = rows[static_cast<size_t>(y)];
    for (size_t j = 0; j < row.weights.size(); ++j) {
      const Rgb* pixels = source.row(row.begin + static_cast<int>(j));
      for (int x = 0; x < width; ++x) {
        const Span& column = columns[static_cast<size_t>(x)];
        Sums& sum = line[static_cast<size_t>(x)];
        for (size_t i = 0; i < column.weights.size(); ++i) {
          const Rgb& pixel = pixels[column.begin + static_cast<int>(i)];
          const uint64_t weight = uint64_t{row.weights[j]} * column.weights[i];
          sum.r += weight * pixel.r;
          sum.g += weight * pixel.g;
          sum.b += weight * pixel.b;
        }
      }
    }
    const auto mean = [area](uint64_t sum) { return static_cast<uint8_t>((sum + area / 2) / area); };
    for (int x = 0; x < width; ++x) {
      const Sums& sum = line[static_cast<size_t>(x)];
      result.at(x, y) = {mean(sum.r), mean(sum.g), mean(sum.b)};
    }
  }
  return result;
}

}  // namespace ldp
