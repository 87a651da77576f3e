#include "core/layers/painting/photo_consistency.h"

#include <simde/x86/sse2.h>

#include <algorithm>
#include <cstring>

#include "core/base/exact_math.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

using namespace tuning;

using Around = PhotoConsistency::Around;

uint32_t three_samples(const uint8_t* from) {
  uint16_t two;
  std::memcpy(&two, from, sizeof two);
  return static_cast<uint32_t>(two) | static_cast<uint32_t>(from[2]) << 16;
}

// Bytes 0 .. 2 and 4 .. 6: three samples of grey and of tint.
simde__m128i samples_of_column(const UprightFrame& frame, int x, int y) {
  const uint64_t both = static_cast<uint64_t>(three_samples(frame.tint.row(x) + y - 1)) << 32 |
                        three_samples(frame.columns.row(x) + y - 1);
  return simde_mm_cvtsi64_si128(static_cast<int64_t>(both));
}

// Of a sample and the least and largest around it: what lies a part of a pixel away.
PhotoConsistency::Range near_range(int sample, int low, int high) {
  const auto part = [](int apart) { return (apart + kWitnessPartOfPx - 1) / kWitnessPartOfPx; };
  return {sample - part(sample - low), sample + part(high - sample)};
}

Around around(const UprightFrame& frame, int x, int y) {
  const simde__m128i before = samples_of_column(frame, x - 1, y), own = samples_of_column(frame, x, y),
                     after = samples_of_column(frame, x + 1, y);
  simde__m128i low = simde_mm_min_epu8(simde_mm_min_epu8(before, own), after),
               high = simde_mm_max_epu8(simde_mm_max_epu8(before, own), after);
  low = simde_mm_min_epu8(simde_mm_min_epu8(low, simde_mm_srli_epi32(low, 8)), simde_mm_srli_epi32(low, 16));
  high = simde_mm_max_epu8(simde_mm_max_epu8(high, simde_mm_srli_epi32(high, 8)), simde_mm_srli_epi32(high, 16));
  const auto lows = static_cast<uint64_t>(simde_mm_cvtsi128_si64(low)),
             highs = static_cast<uint64_t>(simde_mm_cvtsi128_si64(high));
  return {true, near_range(frame.columns.row(x)[y], static_cast<uint8_t>(lows), static_cast<uint8_t>(highs)),
          near_range(frame.tint.row(x)[y], static_cast<uint8_t>(lows >> 32), static_cast<uint8_t>(highs >> 32))};
}

bool has_neighbours(const UprightFrame& frame, int x, int y) {
  if (x < 1 || x + 1 >= frame.camera.width) return false;
  const auto column = static_cast<size_t>(x);
  return y >= frame.valid_begin[column] + 1 && y + 1 < frame.valid_end[column];
}

// What its witnesses tell of a pixel.
struct Told {
  int sum = 0, views = 0;

  // At a place of the other photograph that has samples all around.
  void compare(const Around& own, const UprightFrame& other, int x16, int y16) {
    ++views;
    const int apart = own.greys.outside(interpolated(other.columns, x16 - 8, y16 - 8)) +
                      own.tints.outside(interpolated(other.tint, x16 - 8, y16 - 8));
    sum += std::clamp(apart - kWitnessNoise, 0, kWitnessMostDiffer) * kDifferenceSteps;
  }
};

}  // namespace

PhotoConsistency::Witness::Witness(size_t other, const UprightCamera& from, const UprightCamera& to,
                                   const Eigen::Vector3d& down)
    : frame(other),
      right_of_right(exact_dot(to.right, from.right)),
      right_of_forward(exact_dot(to.right, from.forward)),
      forward_of_right(exact_dot(to.forward, from.right)),
      forward_of_forward(exact_dot(to.forward, from.forward)),
      step_right(exact_dot(to.right, from.centre - to.centre)),
      step_down(exact_dot(down, from.centre - to.centre)),
      step_forward(exact_dot(to.forward, from.centre - to.centre)) {}

PhotoConsistency::PhotoConsistency(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, int columns_apart)
    : frames_(frames), columns_apart_(columns_apart) {
  const Eigen::Vector3d down = -grid.arc.axis();
  for (size_t k = 0; k < frames.size(); ++k) {
    const UprightCamera& own = frames[k].camera;
    std::vector<std::pair<double, size_t>> beside;
    for (size_t j = 0; j < frames.size(); ++j) {
      const UprightCamera& other = frames[j].camera;
      if (j == k || exact_dot(other.forward, own.forward) < kWitnessCosine) continue;
      const Eigen::Vector3d step = other.centre - own.centre;
      beside.emplace_back(exact_dot(step, step), j);
    }
    std::sort(beside.begin(), beside.end());
    std::vector<Witness>& witnesses = witnesses_.emplace_back();
    for (size_t i = 0; i < std::min(beside.size(), kWitnesses); ++i)
      witnesses.emplace_back(beside[i].second, own, frames[beside[i].second].camera, down);
  }
}

std::vector<size_t> PhotoConsistency::witnesses(size_t k) const {
  std::vector<size_t> cameras;
  for (const Witness& witness : witnesses_[k]) cameras.push_back(witness.frame);
  return cameras;
}

kernels::ToWitness PhotoConsistency::Witness::from_column(const UprightCamera& from, const UprightCamera& to, int x,
                                                          const VisibilityMap& own, const VisibilityMap& other) const {
  const auto linear = [](double constant, double slope) {
    return kernels::Linear{static_cast<float>(constant), static_cast<float>(slope)};
  };
  const double to_right = (x + 0.5 - from.cx) / from.focal, forward = forward_of_forward + to_right * forward_of_right,
               right = right_of_forward + to_right * right_of_right, per_row = to.focal / from.focal;
  return {linear(forward, own.scale * step_forward),
          linear(to.focal * right + to.cx * forward, own.scale * (to.focal * step_right + to.cx * step_forward)),
          static_cast<float>(own.scale * to.focal * step_down),
          linear(per_row * (0.5 - from.cy), per_row),
          static_cast<float>(to.width),
          static_cast<float>(to.height),
          static_cast<float>(to.cy),
          static_cast<float>(own.scale / other.scale),
          other.tolerance};
}

void PhotoConsistency::look(size_t k, Pixels& pixels) const {
  const UprightFrame& frame = frames_[k];
  pixels.samples.clear();
  for (const int32_t y : pixels.rows)
    pixels.samples.push_back(has_neighbours(frame, pixels.x, y) ? around(frame, pixels.x, y) : Around{});
}

void PhotoConsistency::differences(size_t k, const Pixels& pixels, const std::vector<const VisibilityMap*>& maps,
                                   std::vector<int>& found) const {
  const UprightFrame& own = frames_[k];
  const uint16_t* surface = maps[k]->inverse_z.row(pixels.x / columns_apart_);
  const size_t count = pixels.rows.size(), padded = count + kernels::kPadding;
  std::vector<int32_t> memory(5 * padded);
  const auto row = [&](size_t i) { return memory.data() + i * padded; };
  int32_t *rows = row(0), *steps = row(1), *x16 = row(2), *y16 = row(3), *nearest = row(4);
  for (size_t i = 0; i < count; ++i) {
    rows[i] = pixels.rows[i];
    steps[i] = surface[rows[i]];
  }
  std::vector<Told> told(count);
  for (const Witness& to : witnesses_[k]) {
    const UprightFrame& other = frames_[to.frame];
    const VisibilityMap& map = *maps[to.frame];
    const kernels::ToWitness there = to.from_column(own.camera, other.camera, pixels.x, *maps[k], map);
    kernels::best().look_from_witness(there, rows, steps, static_cast<int>(count), x16, y16, nearest);
    for (size_t i = 0; i < count; ++i) {
      const int x = x16[i] >> 4, y = y16[i] >> 4;
      if (pixels.samples[i].inside && steps[i] != kUncovered && x16[i] >= 0 && has_neighbours(other, x, y) &&
          map.inverse_z.row(x / columns_apart_)[y] <= nearest[i])
        told[i].compare(pixels.samples[i], other, x16[i], y16[i]);
    }
  }
  found.clear();
  for (const Told& pixel : told) found.push_back(pixel.views == 0 ? kUnknownDifference : pixel.sum / pixel.views);
}

}  // namespace ldp::layers
