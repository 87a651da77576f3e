#include "core/sweep/weighted_median.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/sweep/sweep_kernels.h"
#include "core/sweep/sweep_tuning.h"

namespace ldp::sweep {
namespace {

constexpr int kReach = kernels::kSmoothReach;
constexpr int kStripRows = 16, kStripColumns = 64;

constexpr std::array<uint8_t, kernels::kSmoothWeights> kWeights = [] {
  std::array<uint8_t, kernels::kSmoothWeights> weights{};
  int weight = 255 * 256;
  for (auto& w : weights) {
    w = static_cast<uint8_t>(weight / 256);
    weight = weight * tuning::kMedianDecay / 256;
  }
  return weights;
}();
static_assert(kWeights.back() == 0, "what differs more weighs nothing");

// Some rows of the map and its guide, widened by the reach on both sides.
class Rows {
 public:
  Rows(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps, int begin, int end)
      : begin_(begin), stride_(disparity.width + 2 * kReach + kernels::kPadding) {
    const size_t size = static_cast<size_t>(stride_) * static_cast<size_t>(end - begin);
    grey_.resize(size);
    bin_.resize(size, kernels::kNoBin);
    disparity_.resize(size);
    for (int y = begin; y < end; ++y) {
      const size_t row = static_cast<size_t>(stride_) * static_cast<size_t>(y - begin);
      for (int i = 0; i < disparity.width + 2 * kReach; ++i) {
        int x = i - kReach;
        if (wraps) x = (x + disparity.width) % disparity.width;
        if (x < 0 || x >= disparity.width || disparity.at(x, y) == kNoDisparity) continue;
        const size_t at = row + static_cast<size_t>(i);
        grey_[at] = guide.at(x, y);
        disparity_[at] = disparity.at(x, y);
        bin_[at] = static_cast<uint8_t>(disparity_[at] / kernels::kSmoothBinSteps);
      }
    }
  }

  kernels::SmoothRow at(int y, int x = 0) const {
    const size_t row = static_cast<size_t>(stride_) * static_cast<size_t>(y - begin_) + static_cast<size_t>(x);
    return {grey_.data() + row, bin_.data() + row, disparity_.data() + row};
  }

 private:
  int begin_, stride_;
  std::vector<uint8_t> grey_, bin_;
  std::vector<uint16_t> disparity_;
};

}  // namespace

DisparityMap smooth(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps, const Job& job) {
  DisparityMap out = disparity;
  const int width = disparity.width, height = disparity.height;
  parallel_for(job, (height + kStripRows - 1) / kStripRows, [&](int strip) {
    const int first = strip * kStripRows, last = std::min(height, first + kStripRows);
    const Rows rows(disparity, guide, wraps, std::max(0, first - kReach), std::min(height, last + kReach));
    std::vector<uint16_t> smoothed(static_cast<size_t>(width + kernels::kPadding));
    for (int y = first; y < last; ++y) {
      const int top = std::max(0, y - kReach), bottom = std::min(height, y + kReach + 1);
      for (int x = 0; x < width; x += kStripColumns) {
        const int count = std::min(kStripColumns, width - x);
        std::array<kernels::SmoothRow, 2 * kReach + 1> window;
        for (int i = top; i < bottom; ++i) window[static_cast<size_t>(i - top)] = rows.at(i, x);
        kernels::best().smooth_row(window.data(), bottom - top, y - top, kWeights.data(), count, smoothed.data());
        for (int i = 0; i < count; ++i)
          if (disparity.at(x + i, y) != kNoDisparity) out.at(x + i, y) = smoothed[static_cast<size_t>(i)];
      }
    }
  });
  return out;
}

}  // namespace ldp::sweep
