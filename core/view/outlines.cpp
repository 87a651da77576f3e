#include "core/view/outlines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

// Around a pixel, row by row; of 20.
constexpr std::array<uint32_t, 9> kWeights = {1, 2, 1, 2, 8, 2, 1, 2, 1};
constexpr uint32_t kSumOfWeights = 20;

// Whether inverse z, which is linear on the screen across a plane, is not from a to b by way of the middle.
bool is_step(float a, float middle, float b, float least_step) {
  return std::abs(a + b - 2 * middle) > kOutlineShare * std::max(std::max(a, b), middle) + least_step;
}

bool is_beside(float inverse_z, float other, float least_step) {
  return std::abs(other - inverse_z) <= kOutlineShare * inverse_z + least_step;
}

// What a view shows before its outlines are softened.
struct Sharp {
  const Plane<float> inverse_z;
  const RgbImage colour;
  const Plane<uint8_t> alpha;
};

// The pixel and those around it; of the picture's edge, the edge itself beyond it.
template <class Use>
void for_neighbours(const Sharp& from, int x, int y, Use use) {
  size_t i = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      use(i++, from.colour.index(std::clamp(x + dx, 0, from.colour.width - 1),
                                 std::clamp(y + dy, 0, from.colour.height - 1)));
}

// 1 where the pixels of a row are beside a step of depth.
void find_steps(const Plane<float>& inverse_z, int y, float least_step, std::vector<uint8_t>& steps) {
  const float *above = inverse_z.row(std::max(0, y - 1)), *own = inverse_z.row(y),
              *below = inverse_z.row(std::min(inverse_z.height - 1, y + 1));
  const int last = inverse_z.width - 1;
  const auto look = [&](int left, int x, int right) {
    const bool across = is_step(own[left], own[x], own[right], least_step),
               down = is_step(above[x], own[x], below[x], least_step),
               falling = is_step(above[left], own[x], below[right], least_step),
               rising = is_step(below[left], own[x], above[right], least_step);
    return static_cast<uint8_t>(across | down | falling | rising);
  };
  steps.resize(static_cast<size_t>(inverse_z.width));
  steps.front() = look(0, 0, std::min(1, last));
  for (int x = 1; x < last; ++x) steps[static_cast<size_t>(x)] = look(x - 1, x, x + 1);
  if (last > 0) steps.back() = look(last - 1, last, last);
}

// Of its surface there is hardly another pixel around it: chance, or a thread's end.
bool is_speck(const Sharp& from, int x, int y, float least_step) {
  const float own = from.inverse_z.at(x, y);
  int beside = -1;  // itself
  for_neighbours(from, x, y, [&](size_t, size_t pixel) {
    beside += is_beside(own, from.inverse_z.samples[pixel], least_step) ? 1 : 0;
  });
  return beside <= kSpeckNeighbours;
}

// A speck counts for nothing.
Rgb mean_around(const Sharp& from, int x, int y, float least_step, uint32_t& covered) {
  const bool speck = is_speck(from, x, y, least_step);
  const float own = from.inverse_z.at(x, y);
  uint32_t r = 0, g = 0, b = 0, sum = 0;
  for_neighbours(from, x, y, [&](size_t i, size_t pixel) {
    if (speck && is_beside(own, from.inverse_z.samples[pixel], least_step)) return;
    const uint32_t weight = kWeights[i] * from.alpha.samples[pixel];
    const Rgb& colour = from.colour.samples[pixel];
    r += weight * colour.r, g += weight * colour.g, b += weight * colour.b, sum += weight;
  });
  covered = sum;
  if (sum == 0) return from.colour.at(x, y);
  const auto mean = [&](uint32_t channel) { return static_cast<uint8_t>((channel + sum / 2) / sum); };
  return {mean(r), mean(g), mean(b)};
}

float farthest_around(const Sharp& from, int x, int y) {
  float farthest = INFINITY;
  for_neighbours(from, x, y, [&](size_t, size_t pixel) {
    if (from.inverse_z.samples[pixel] >= 0) farthest = std::min(farthest, from.inverse_z.samples[pixel]);
  });
  return farthest;
}

}  // namespace

void soften_outlines(float least_step, const Job& job, Plane<float>& inverse_z, RgbImage& colour,
                     Plane<uint8_t>& alpha) {
  const Sharp from{inverse_z, colour, alpha};
  parallel_for(job, colour.height, [&](int y) {
    std::vector<uint8_t> steps;
    find_steps(from.inverse_z, y, least_step, steps);
    for (int x = 0; x < colour.width; ++x) {
      if (steps[static_cast<size_t>(x)] == 0) continue;
      uint32_t covered = 0;
      const Rgb mean = mean_around(from, x, y, least_step, covered);
      if (from.alpha.at(x, y) == 0) {
        if (covered * kCrackShare < kSumOfWeights * 255) continue;
        alpha.at(x, y) = 255;
        inverse_z.at(x, y) = farthest_around(from, x, y);
      }
      colour.at(x, y) = mean;
    }
  });
}

}  // namespace ldp::view
