// One slab of the disparity space image: the matching cost of every ray of a window at ONE disparity, after the 5x5
// box, the +-1 shiftable window (paper 3.2) and adaptive support (sweep_kernels.h). Columns stream: seven columns of
// costs, five of sums and three of minima are all it holds.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cost_source.h"
#include "core/sweep/voxel_lines.h"

namespace ldp::sweep {

constexpr int kBoxArea = 25;
constexpr int kHalo = 3;  // 2 of the box, 1 of the shiftable window
constexpr int kSupport = 2 * kHalo + 1;

// Buffers of one thread at work; grown when a window is larger than any before, else reused.
class SlabScratch {
 public:
  explicit SlabScratch(const kernels::Kernels& with = kernels::best()) : kernels(with) {}
  void reserve(int height, int longest_column);

  const kernels::Kernels& kernels;
  std::vector<uint8_t> blended, blended_tint;  // a source column between two
  std::vector<uint8_t> samples[kernels::kMaxViews], tints[kernels::kMaxViews], masks[kernels::kMaxViews];
  std::vector<uint8_t> phi[kSupport], medians[kSupport], reference_tint;
  // Of each column's reference, over kSupport rows.
  struct Range {
    std::vector<uint8_t> low, high;
  } greys[kSupport], hues[kSupport];
  std::vector<uint8_t> contrast;
  std::vector<uint16_t> sums[5], total, lowest[3], box, cost;
};

class SlabSink {
 public:
  virtual ~SlabSink() = default;
  // Column x of the window (0 ..): `cost` in 1/(kBoxArea kCostScale) grey levels, and the median grey. `contrast` is
  // null unless it was asked for: that of the reference over all pixels on which a cost depends.
  virtual void column(int x, const uint16_t* cost, const uint8_t* median, const uint8_t* contrast) = 0;
};

void sweep_slab(const LineTable& lines, double inverse_depth, const Window& window, int prior_cost, bool with_contrast,
                SlabScratch& scratch, SlabSink& sink);

}  // namespace ldp::sweep
