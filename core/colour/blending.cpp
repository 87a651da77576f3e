#include "core/colour/blending.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/colour/colour_tuning.h"

namespace ldp::colour {
namespace {

// Rounded to the nearest; halves away from zero.
int quotient(int64_t sum, int64_t count) { return static_cast<int>((sum + (sum < 0 ? -count : count) / 2) / count); }

// Where a pixel's middle lies between those of two cells: `beyond` of `whole` towards the one after `first`, which is
// -1 before the first middle.
struct Between {
  int first = 0;
  int64_t beyond = 0, whole = 1;
};

Between between(int64_t px, int64_t size_px, int64_t cells) {
  const int64_t whole = 2 * size_px, place = (2 * px + 1) * cells + size_px;
  return {static_cast<int>(place / whole) - 1, place % whole, whole};
}

}  // namespace

Colour consensus(std::span<const Colour> samples) {
  if (samples.size() < 3) return samples.front();
  const size_t drop = (samples.size() + 1) / 4;
  Colour result{};
  for (size_t k = 0; k < result.size(); ++k) {
    std::array<int, 1 + kNeighbourViews> sorted;
    sorted.fill(std::numeric_limits<int>::max());
    std::transform(samples.begin(), samples.end(), sorted.begin(), [k](const Colour& c) { return c[k]; });
    std::sort(sorted.begin(), sorted.end());
    const auto kept = static_cast<std::ptrdiff_t>(samples.size() - 2 * drop);
    const auto begin = sorted.begin() + static_cast<std::ptrdiff_t>(drop);
    result[k] = quotient(std::accumulate(begin, begin + kept, 0), kept);
  }
  return result;
}

BrightnessDifferences::BrightnessDifferences(const PanoramaGrid& grid)
    : width_(grid.width),
      height_(grid.height),
      wraps_(grid.wraps),
      columns_((grid.width + tuning::kBrightnessCellPx - 1) / tuning::kBrightnessCellPx),
      rows_((grid.height + tuning::kBrightnessCellPx - 1) / tuning::kBrightnessCellPx),
      cells_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_) * kNeighbourViews) {}

void BrightnessDifferences::clear() { std::fill(cells_.begin(), cells_.end(), std::nullopt); }

size_t BrightnessDifferences::place(int column, int row, int neighbour) const {
  const auto cell = static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  return cell * kNeighbourViews + static_cast<size_t>(neighbour);
}

void BrightnessDifferences::set(int column, int row, int neighbour, std::vector<Colour>& samples) {
  if (samples.size() < tuning::kBrightnessLeastSamples) return;
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  Colour median{};
  for (size_t k = 0; k < median.size(); ++k) {
    std::nth_element(samples.begin(), middle, samples.end(),
                     [k](const Colour& a, const Colour& b) { return a[k] < b[k]; });
    median[k] = (*middle)[k];
  }
  cells_[place(column, row, neighbour)] = median;
}

std::optional<Colour> BrightnessDifferences::at(int x, int y, int neighbour) const {
  const Between across = between(x, width_, columns_), down = between(y, height_, rows_);
  std::array<int64_t, 3> sum{};
  int64_t weights = 0;
  for (const int j : {0, 1})
    for (const int i : {0, 1}) {
      int column = across.first + i;
      const int row = down.first + j;
      if (wraps_) column = (column + columns_) % columns_;
      if (column < 0 || row < 0 || column >= columns_ || row >= rows_) continue;
      const std::optional<Colour>& known = cells_[place(column, row, neighbour)];
      if (!known) continue;
      const int64_t weight =
          (i ? across.beyond : across.whole - across.beyond) * (j ? down.beyond : down.whole - down.beyond);
      weights += weight;
      for (size_t k = 0; k < 3; ++k) sum[k] += weight * (*known)[k];
    }
  if (weights == 0) return {};
  return Colour{quotient(sum[0], weights), quotient(sum[1], weights), quotient(sum[2], weights)};
}

}  // namespace ldp::colour
