#include "agreement.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace ldp {
namespace {

// Rounded to the nearest; halves away from zero.
int quotient(int64_t sum, int64_t count) { return static_cast<int>((sum + (sum < 0 ? -count : count) / 2) / count); }

int floor_quotient(int value, int divisor) { return (value - (value < 0 ? divisor - 1 : 0)) / divisor; }

}  // namespace

Colour agreed(std::span<const Colour> samples) {
  if (samples.size() < 3) return samples.front();
  const size_t drop = (samples.size() + 1) / 4;
  Colour result{};
  for (size_t k = 0; k < result.size(); ++k) {
    std::array<int, 1 + kWitnesses> sorted;
    for (size_t i = 0; i < samples.size(); ++i) {
      size_t place = i;
      for (; place > 0 && sorted[place - 1] > samples[i][k]; --place) sorted[place] = sorted[place - 1];
      sorted[place] = samples[i][k];
    }
    int sum = 0;
    for (size_t i = drop; i < samples.size() - drop; ++i) sum += sorted[i];
    result[k] = quotient(sum, static_cast<int64_t>(samples.size() - 2 * drop));
  }
  return result;
}

BrightnessDifferences::BrightnessDifferences(const PanoramaGrid& grid)
    : wraps_(grid.wraps),
      columns_((grid.width + kCellPx - 1) / kCellPx),
      rows_((grid.height + kCellPx - 1) / kCellPx),
      cells_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_) * kWitnesses) {}

void BrightnessDifferences::clear() { std::fill(cells_.begin(), cells_.end(), std::nullopt); }

const std::optional<Colour>* BrightnessDifferences::cell(int column, int row, int witness) const {
  if (wraps_) column = (column + columns_) % columns_;
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return nullptr;
  const auto place = static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  return &cells_[place * kWitnesses + static_cast<size_t>(witness)];
}

void BrightnessDifferences::set(int column, int row, int witness, std::vector<Colour>& samples) {
  if (samples.size() < kLeastSamples) return;
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  Colour median{};
  for (size_t k = 0; k < median.size(); ++k) {
    std::nth_element(samples.begin(), middle, samples.end(),
                     [k](const Colour& a, const Colour& b) { return a[k] < b[k]; });
    median[k] = (*middle)[k];
  }
  const auto place = static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  cells_[place * kWitnesses + static_cast<size_t>(witness)] = median;
}

std::optional<Colour> BrightnessDifferences::at(int x, int y, int witness) const {
  constexpr int kCell = 2 * kCellPx;  // in half pixels, so that both pixels' and cells' centres are integers
  const int px = 2 * x + 1 - kCellPx, py = 2 * y + 1 - kCellPx;
  const int column = floor_quotient(px, kCell), row = floor_quotient(py, kCell);
  std::array<int64_t, 3> sum{};
  int64_t weights = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const std::optional<Colour>* known = cell(column + i, row + j, witness);
      if (!known || !*known) continue;
      const int beyond_x = px - column * kCell, beyond_y = py - row * kCell;
      const int64_t weight = (i ? beyond_x : kCell - beyond_x) * (j ? beyond_y : kCell - beyond_y);
      weights += weight;
      for (size_t k = 0; k < 3; ++k) sum[k] += weight * (**known)[k];
    }
  if (weights == 0) return {};
  return Colour{quotient(sum[0], weights), quotient(sum[1], weights), quotient(sum[2], weights)};
}

}  // namespace ldp
