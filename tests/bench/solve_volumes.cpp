#include "tests/bench/solve_volumes.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "core/photos/images.h"

namespace ldp {

Volume::Volume(int width, int height, int labels, bool wraps)
    : cost(static_cast<size_t>(width) * static_cast<size_t>(height) * static_cast<size_t>(labels)),
      least(cost.size() / static_cast<size_t>(labels)),
      width_(width),
      height_(height),
      labels_(labels),
      wraps_(wraps) {}

void Volume::read(const Window& window, uint8_t* out_cost, uint8_t* out_median) const {
  const auto column = static_cast<size_t>(window.height) * static_cast<size_t>(labels_);
  for (int x = 0; x < window.width; ++x) {
    const size_t from = index((window.x + x) % width_, window.y), to = static_cast<size_t>(x) * column;
    std::memcpy(out_cost + to, cost.data() + from, column);
    if (median.empty())
      std::memset(out_median + to, 0, column);
    else
      std::memcpy(out_median + to, median.data() + from, column);
  }
}

namespace {

constexpr int kChannels = 3;

int channel(const Rgb& colour, int c) { return c == 0 ? colour.r : c == 1 ? colour.g : colour.b; }

struct Span {
  int low, centre, high;
};

// A pixel's value and the range of it and its two half-way neighbours in the row (Birchfield and Tomasi).
Span span_of(const RgbImage& image, int x, int y, int c) {
  const int centre = channel(image.at(x, y), c);
  const int left = x == 0 ? centre : (centre + channel(image.at(x - 1, y), c)) / 2;
  const int right = x == image.width - 1 ? centre : (centre + channel(image.at(x + 1, y), c)) / 2;
  return {std::min({left, centre, right}), centre, std::max({left, centre, right})};
}

int dissimilarity(const RgbImage& left, const RgbImage& right, int x, int y, int disparity) {
  if (x - disparity < 0) return kChannels * 255;
  int sum = 0;
  for (int c = 0; c < kChannels; ++c) {
    const Span a = span_of(left, x, y, c), b = span_of(right, x - disparity, y, c);
    sum += std::min(std::max({0, a.centre - b.high, b.low - a.centre}),
                    std::max({0, b.centre - a.high, a.low - b.centre}));
  }
  return sum;
}

uint8_t factor(const Rgb& a, const Rgb& b, int gradient, int factor_below) {
  int sum = 0;
  for (int c = 0; c < kChannels; ++c) {
    const int difference = channel(a, c) - channel(b, c);
    sum += difference * difference;
  }
  return static_cast<uint8_t>(sum < kChannels * gradient * gradient ? factor_below : 1);
}

EdgeFactors factors_of(const RgbImage& image, int gradient, int factor_below) {
  EdgeFactors factors{Plane<uint8_t>(image.width, image.height, 1), Plane<uint8_t>(image.width, image.height, 1)};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (x + 1 < image.width)
        factors.right.at(x, y) = factor(image.at(x, y), image.at(x + 1, y), gradient, factor_below);
      if (y + 1 < image.height)
        factors.down.at(x, y) = factor(image.at(x, y), image.at(x, y + 1), gradient, factor_below);
    }
  return factors;
}

struct StereoSettings {
  std::string name;
  int disparities;
  int lambda, truncation, gradient, factor_below;
};

// Disparities are merged evenly into 16 labels, each with the least of its disparities' costs.
Problem stereo(const StereoSettings& settings) {
  const std::string stem = std::string(LDP_SHARED_DATA) + "/stereo/" + settings.name;
  const RgbImage left = read_image(stem + "-imL.png"), right = read_image(stem + "-imR.png");
  Problem problem{settings.name,
                  Volume(left.width, left.height, 16, false),
                  factors_of(left, settings.gradient, settings.factor_below),
                  {},
                  0};
  for (int x = 0; x < left.width; ++x)
    for (int y = 0; y < left.height; ++y) {
      int cost[16];
      std::fill_n(cost, 16, 1 << 20);
      for (int d = 0; d < settings.disparities; ++d) {
        int& merged = cost[d * 16 / settings.disparities];
        merged = std::min(merged, dissimilarity(left, right, x, y, d));
      }
      const int least = *std::min_element(cost, cost + 16);
      problem.volume.least[problem.volume.index(x, y) / 16] = least;
      for (int l = 0; l < 16; ++l)
        problem.volume.cost[problem.volume.index(x, y) + static_cast<size_t>(l)] =
            static_cast<uint8_t>(std::min(255, cost[l] - least));
    }
  problem.options.lambda = static_cast<double>(settings.lambda) / kCostScale;
  problem.options.truncation = settings.truncation;
  problem.options.contrast = 0;
  problem.unit = 1.0 / kCostScale;
  return problem;
}

int mirrored(int i, int n) {
  const int k = i % (2 * n);
  return k < n ? k : 2 * n - 1 - k;
}

}  // namespace

Problem tsukuba() { return stereo({"tsukuba", 16, 20, 2, 8, 2}); }
Problem teddy16() { return stereo({"teddy", 60, 10, 1, 10, 3}); }

Problem mirror_tiled(const Problem& problem, int width, int height) {
  const Volume& tile = problem.volume;
  Problem tiled{problem.name + std::to_string(width),
                Volume(width, height, tile.labels(), false),
                {Plane<uint8_t>(width, height, 1), Plane<uint8_t>(width, height, 1)},
                problem.options,
                problem.unit};
  for (int x = 0; x < width; ++x)
    for (int y = 0; y < height; ++y) {
      const int tx = mirrored(x, tile.width()), ty = mirrored(y, tile.height());
      std::copy_n(tile.cost.begin() + static_cast<ptrdiff_t>(tile.index(tx, ty)), tile.labels(),
                  tiled.volume.cost.begin() + static_cast<ptrdiff_t>(tiled.volume.index(x, y)));
      tiled.volume.least[tiled.volume.index(x, y) / 16] = tile.least[tile.index(tx, ty) / 16];
      const int tx2 = mirrored(x + 1, tile.width()), ty2 = mirrored(y + 1, tile.height());
      tiled.factors.right.at(x, y) = problem.factors.right.at(std::min(tx, tx2), ty);
      tiled.factors.down.at(x, y) = problem.factors.down.at(tx, std::min(ty, ty2));
    }
  return tiled;
}

}  // namespace ldp
