#include "core/export/rags.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace ldp {
namespace {

int within(int i, int count) { return std::clamp(i, 0, count - 1); }

// Whether a sample within the reach of number i has the value.
template <class Sample>
bool is_near(int i, int count, Sample has_value) {
  for (int near = i - kThread_px; near <= i + kThread_px; ++near)
    if (has_value(within(near, count))) return true;
  return false;
}

// Every sample within a square around one of the value takes it.
void grow(Plane<uint8_t>& mask, uint8_t value) {
  const int width = mask.width, height = mask.height;
  Plane<uint8_t> grown = mask;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (is_near(x, width, [&](int near) { return mask.at(near, y) == value; })) grown.at(x, y) = value;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (is_near(y, height, [&](int near) { return grown.at(x, near) == value; })) mask.at(x, y) = value;
}

// The pixels that hang together with the first one, by their sides; they are made absent in `waiting`.
std::vector<size_t> take_part(Plane<uint8_t>& waiting, size_t first) {
  std::vector<size_t> part = {first};
  waiting.samples[first] = 0;
  for (size_t i = 0; i < part.size(); ++i) {
    const auto width = static_cast<size_t>(waiting.width);
    const int x = static_cast<int>(part[i] % width), y = static_cast<int>(part[i] / width);
    constexpr std::array<std::array<int, 2>, 4> kBeside = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    for (const auto& [dx, dy] : kBeside) {
      const size_t beside = waiting.index(within(x + dx, waiting.width), within(y + dy, waiting.height));
      if (waiting.samples[beside] == 0) continue;
      waiting.samples[beside] = 0;
      part.push_back(beside);
    }
  }
  return part;
}

}  // namespace

void trim_rags(Plane<uint8_t>& present) {
  Plane<uint8_t> opened = present;
  for (uint8_t& sample : opened.samples) sample = sample != 0 ? 1 : 0;
  grow(opened, 0);
  grow(opened, 1);
  Plane<uint8_t> waiting = opened;
  const double least = kIsland * static_cast<double>(present.samples.size());
  for (size_t pixel = 0; pixel < waiting.samples.size(); ++pixel) {
    if (waiting.samples[pixel] == 0) continue;
    const std::vector<size_t> part = take_part(waiting, pixel);
    if (static_cast<double>(part.size()) >= least) continue;
    for (const size_t of_island : part) opened.samples[of_island] = 0;
  }
  if (std::find(opened.samples.begin(), opened.samples.end(), 1) == opened.samples.end()) return;
  for (size_t pixel = 0; pixel < opened.samples.size(); ++pixel)
    if (opened.samples[pixel] == 0) present.samples[pixel] = 0;
}

Plane<uint8_t> beyond_border(const Plane<uint8_t>& present) {
  Plane<uint8_t> waiting = present, beyond(present.width, present.height);
  for (uint8_t& sample : waiting.samples) sample = sample == 0 ? 1 : 0;
  const auto begin_at = [&](int x, int y) {
    if (waiting.at(x, y) == 0) return;
    for (const size_t pixel : take_part(waiting, waiting.index(x, y))) beyond.samples[pixel] = 1;
  };
  for (int x = 0; x < present.width; ++x) begin_at(x, 0), begin_at(x, present.height - 1);
  for (int y = 0; y < present.height; ++y) begin_at(0, y), begin_at(present.width - 1, y);
  return beyond;
}

}  // namespace ldp
