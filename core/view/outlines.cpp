#include "core/view/outlines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

constexpr std::array<uint32_t, 9> kWeights = {1, 2, 1, 2, 8, 2, 1, 2, 1};  // around a pixel, row by row

// Whether inverse z bends from a to b by way of the middle; across a plane it is linear on the screen. Holes bend
// nothing.
bool is_bend(float a, float middle, float b, float least_step) {
  return std::min(std::min(a, b), middle) >= 0 &&
         std::abs(a + b - 2 * middle) > kOutlineShare * std::max(std::max(a, b), middle) + least_step;
}

bool is_beside(float inverse_z, float other, float least_step) {
  return other >= 0 && std::abs(other - inverse_z) <= kOutlineShare * inverse_z + least_step;
}

struct Pixels {
  const Plane<float>& inverse_z;
  const RgbImage& colour;
  const Plane<uint8_t>& alpha;
};

// A pixel that is not at the picture's edge, and those around it.
template <class Use>
void for_neighbours(const Pixels& from, int x, int y, Use use) {
  size_t i = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) use(i++, from.colour.index(x + dx, y + dy));
}

// 1 where inverse z bends at the pixels of a row; none at the picture's edge.
void find_bends(const Plane<float>& inverse_z, int y, float least_step, std::vector<uint8_t>& bends) {
  const float *above = inverse_z.row(y - 1), *own = inverse_z.row(y), *below = inverse_z.row(y + 1);
  bends.assign(static_cast<size_t>(inverse_z.width), 0);
  for (int x = 1; x + 1 < inverse_z.width; ++x) {
    const bool across = is_bend(own[x - 1], own[x], own[x + 1], least_step),
               down = is_bend(above[x], own[x], below[x], least_step),
               falling = is_bend(above[x - 1], own[x], below[x + 1], least_step),
               rising = is_bend(below[x - 1], own[x], above[x + 1], least_step);
    bends[static_cast<size_t>(x)] = static_cast<uint8_t>(across | down | falling | rising);
  }
}

// Of its surface there is hardly another pixel around it: chance, or a thread's end.
bool is_speck(const Pixels& from, int x, int y, float least_step) {
  const float own = from.inverse_z.at(x, y);
  int beside = -1;  // itself
  for_neighbours(from, x, y, [&](size_t, size_t pixel) {
    beside += is_beside(own, from.inverse_z.samples[pixel], least_step) ? 1 : 0;
  });
  return beside <= kSpeckNeighbours;
}

// Of the neighbours that count; of none of these that are covered, the pixel's own.
template <class Counts>
Rgb mean_around(const Pixels& from, int x, int y, Counts counts) {
  uint32_t r = 0, g = 0, b = 0, sum = 0;
  for_neighbours(from, x, y, [&](size_t i, size_t pixel) {
    if (!counts(pixel)) return;
    const uint32_t weight = kWeights[i] * from.alpha.samples[pixel];
    const Rgb& colour = from.colour.samples[pixel];
    r += weight * colour.r, g += weight * colour.g, b += weight * colour.b, sum += weight;
  });
  if (sum == 0) return from.colour.at(x, y);
  const auto mean = [&](uint32_t channel) { return static_cast<uint8_t>((channel + sum / 2) / sum); };
  return {mean(r), mean(g), mean(b)};
}

// Whether a surface is shown on both sides of a hole, which is not at the picture's edge: left and right, or above and
// below. (Of a slanting crack, too; across a diagonal the corners of any hole would be.)
bool is_crack(const Plane<float>& inverse_z, int x, int y) {
  return (inverse_z.at(x - 1, y) >= 0 && inverse_z.at(x + 1, y) >= 0) ||
         (inverse_z.at(x, y - 1) >= 0 && inverse_z.at(x, y + 1) >= 0);
}

float farthest_around(const Pixels& from, int x, int y) {
  float farthest = INFINITY;
  for_neighbours(from, x, y, [&](size_t, size_t pixel) {
    if (from.inverse_z.samples[pixel] >= 0) farthest = std::min(farthest, from.inverse_z.samples[pixel]);
  });
  return farthest;
}

}  // namespace

void close_cracks(float least_step, Plane<float>& inverse_z, RgbImage& colour, Plane<uint8_t>& alpha) {
  struct Crack {
    size_t pixel;
    Rgb colour;
    float inverse_z;
  };
  const Pixels from{inverse_z, colour, alpha};
  std::vector<Crack> cracks;
  for (int y = 1; y + 1 < colour.height; ++y)
    for (int x = 1; x + 1 < colour.width; ++x) {
      if (alpha.at(x, y) != 0 || !is_crack(inverse_z, x, y)) continue;
      const float farthest = farthest_around(from, x, y);
      const auto counts = [&](size_t pixel) { return is_beside(farthest, inverse_z.samples[pixel], least_step); };
      cracks.push_back({colour.index(x, y), mean_around(from, x, y, counts), farthest});
    }
  for (const Crack& crack : cracks) {
    colour.samples[crack.pixel] = crack.colour;
    inverse_z.samples[crack.pixel] = crack.inverse_z;
    alpha.samples[crack.pixel] = 255;
  }
}

void soften_outlines(float least_step, const Plane<float>& inverse_z, const Plane<uint8_t>& alpha, const Job& job,
                     RgbImage& colour) {
  const RgbImage sharp = colour;
  const Pixels from{inverse_z, sharp, alpha};
  parallel_for(job, std::max(0, colour.height - 2), [&](int row) {
    const int y = row + 1;
    std::vector<uint8_t> bends;
    find_bends(from.inverse_z, y, least_step, bends);
    for (int x = 0; x < colour.width; ++x) {
      if (bends[static_cast<size_t>(x)] == 0 || alpha.at(x, y) == 0) continue;
      const float own = inverse_z.at(x, y);
      const bool speck = is_speck(from, x, y, least_step);
      const auto counts = [&](size_t pixel) { return !speck || !is_beside(own, inverse_z.samples[pixel], least_step); };
      colour.at(x, y) = mean_around(from, x, y, counts);
    }
  });
}

}  // namespace ldp::view
