#include "core/rectify/background_subtraction.h"

#include <algorithm>
#include <vector>

#include "core/rectify/rectify_tuning.h"
#include "core/rectify/resample.h"

namespace ldp::rectification {
namespace {

constexpr int kBin = kBinLevels * kSampleScale;
constexpr int kBins = 255 * kSampleScale / kBin + 3;  // one more at either end
constexpr int kWeightBits = 6;                        // of interpolation along one axis
constexpr int kMiddle = 128 * kSampleScale, kHighest = 255 * kSampleScale;

struct Cell {
  uint64_t sum = 0, count = 0;

  void add(const Cell& other, uint64_t weight) {
    sum += weight * other.sum;
    count += weight * other.count;
  }
};

// Between which cells a position lies, and the weight of the second in 1/64.
struct Between {
  size_t first = 0;
  uint64_t weight = 0;
};

// `position` counts half units from the first cell's beginning; there is one more cell before that.
Between between(int position, int cell) {
  const int from_centre = position + cell;  // of the cell before, in half units
  return {static_cast<size_t>(from_centre / (2 * cell)),
          static_cast<uint64_t>((from_centre % (2 * cell) << kWeightBits) / (2 * cell))};
}

class BilateralGrid {
 public:
  explicit BilateralGrid(const Plane<uint16_t>& grey)
      : cell_px_(std::max(4, (std::max(grey.width, grey.height) + kCellsAcross - 1) / kCellsAcross)),
        across_(static_cast<size_t>((grey.width - 1) / cell_px_ + 3)),
        down_(static_cast<size_t>((grey.height - 1) / cell_px_ + 3)),
        cells_(across_ * down_ * kBins) {
    for (int y = 0; y < grey.height; ++y) {
      for (int x = 0; x < grey.width; ++x) {
        const auto bin = static_cast<size_t>(grey.at(x, y) / kBin + 1);
        const auto column = static_cast<size_t>(x / cell_px_ + 1), row = static_cast<size_t>(y / cell_px_ + 1);
        Cell& cell = cells_[(row * across_ + column) * kBins + bin];
        cell.sum += grey.at(x, y);
        ++cell.count;
      }
    }
    smooth(1, kBins);
    smooth(kBins, across_);
    smooth(kBins * across_, down_);
  }

  // The grid at one row of pixels: across x bins.
  void cut(int y, std::vector<Cell>& row) const {
    const Between at = between(2 * y + 1, cell_px_);
    const size_t size = across_ * kBins;
    row.assign(size, {});
    for (size_t i = 0; i < size; ++i) {
      row[i].add(cells_[at.first * size + i], kOne - at.weight);
      row[i].add(cells_[(at.first + 1) * size + i], at.weight);
    }
  }

  // The mean of what is like `value` near column x of a row that was cut.
  int mean(const std::vector<Cell>& row, int x, int value) const {
    const Between column = between(2 * x + 1, cell_px_), bin = between(2 * value + 1, kBin);
    Cell total;
    for (size_t i = 0; i < 2; ++i) {
      const uint64_t weight = i == 0 ? kOne - column.weight : column.weight;
      const Cell* cell = row.data() + (column.first + i) * kBins + bin.first;
      total.add(cell[0], weight * (kOne - bin.weight));
      total.add(cell[1], weight * bin.weight);
    }
    return static_cast<int>(total.sum / total.count);
  }

 private:
  static constexpr uint64_t kOne = 1 << kWeightBits;

  // [1 2 1] along the axis whose neighbours lie `stride` cells apart, `length` of them.
  void smooth(size_t stride, size_t length) {
    for (size_t start = 0; start < cells_.size(); ++start) {
      if (start / stride % length != 0) continue;
      Cell before;
      for (size_t i = 0; i < length; ++i) {
        Cell& cell = cells_[start + i * stride];
        const Cell here = cell;
        cell.add(here, 1);
        cell.add(before, 1);
        if (i + 1 < length) cell.add(cells_[start + (i + 1) * stride], 1);
        before = here;
      }
    }
  }

  int cell_px_;
  size_t across_, down_;
  std::vector<Cell> cells_;  // rows x columns x bins
};

}  // namespace

Plane<uint16_t> flatten(const Plane<uint16_t>& grey, const Job& job) {
  const BilateralGrid grid(grey);
  Plane<uint16_t> flat(grey.width, grey.height);
  parallel_for(job, (grey.height + kRowsAtOnce - 1) / kRowsAtOnce, [&](int strip) {
    std::vector<Cell> row;
    for (int y = strip * kRowsAtOnce; y < std::min(grey.height, (strip + 1) * kRowsAtOnce); ++y) {
      grid.cut(y, row);
      for (int x = 0; x < grey.width; ++x) {
        const int value = grey.at(x, y), shading = grid.mean(row, x, value) - kMiddle;
        flat.at(x, y) = static_cast<uint16_t>(std::clamp(value - shading * 4 / 5, 0, kHighest));
      }
    }
  });
  return flat;
}

}  // namespace ldp::rectification
