#include "smooth.h"

#include <algorithm>
#include <array>
#include <vector>

#include "kernels.h"

namespace ldp {
namespace {

constexpr int kReach = kernels::kSmoothReach;
constexpr int kDecay = 217;  // of 256: weight that each grey level of difference leaves, exp(-1/6)
constexpr int kRowsAtOnce = 16, kColumnsAtOnce = 64;
// Where the guide is plain the noise of matching reaches further than one window, and renderers tear surfaces that are
// not even to a few pixels of parallax: such pixels are smoothed once more. (Each fifth photo left out, with v without:
// desk_sweep 21.72 v 21.46 dB, kitchen_sideways 24.09 v 24.08, redkitchen_arc 23.61 v 23.61; all pixels once more:
// 21.63, 24.01, 23.72.)
constexpr int kContrastReach = 3, kPlainContrast = 8;

constexpr std::array<uint8_t, kernels::kSmoothWeights> kWeights = [] {
  std::array<uint8_t, kernels::kSmoothWeights> weights{};
  int weight = 255 * 256;
  for (auto& w : weights) {
    w = static_cast<uint8_t>(weight / 256);
    weight = weight * kDecay / 256;
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

// The contrast of the guide around each pixel of a row, as the kernels' contrast7 takes it.
class Contrasts {
 public:
  Contrasts(const Rows& rows, int begin, int end, int width) : begin_(begin), end_(end) {
    const auto size = static_cast<size_t>(width + kernels::kPadding);
    for (int y = begin; y < end; ++y) {
      low_.emplace_back(size);
      high_.emplace_back(size);
      const uint8_t* from = rows.at(y).grey + kReach - kContrastReach;
      kernels::best().range7(from, width, low_.back().data(), high_.back().data());
    }
  }

  void find(int y, int width, uint8_t* contrast) const {
    kernels::Tinted<const uint8_t> low[2 * kContrastReach + 1], high[2 * kContrastReach + 1];
    for (int k = 0; k <= 2 * kContrastReach; ++k) {
      const auto row = static_cast<size_t>(std::clamp(y + k - kContrastReach, begin_, end_ - 1) - begin_);
      low[k] = {low_[row].data(), low_[row].data()};
      high[k] = {high_[row].data(), high_[row].data()};
    }
    kernels::best().contrast7(low, high, width, contrast);
  }

 private:
  int begin_, end_;
  std::vector<std::vector<uint8_t>> low_, high_;
};

enum class Where { everywhere, where_plain };

DisparityMap smooth_once(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps, Where where,
                         const Job& job) {
  DisparityMap out = disparity;
  const int width = disparity.width, height = disparity.height;
  parallel_for(job, (height + kRowsAtOnce - 1) / kRowsAtOnce, [&](int strip) {
    const int first = strip * kRowsAtOnce, last = std::min(height, first + kRowsAtOnce);
    const int above = std::max(0, first - kReach), below = std::min(height, last + kReach);
    const Rows rows(disparity, guide, wraps, above, below);
    const Contrasts contrasts(rows, above, where == Where::where_plain ? below : above, width);
    std::vector<uint16_t> smoothed(static_cast<size_t>(width + kernels::kPadding));
    std::vector<uint8_t> contrast(smoothed.size(), 0);
    for (int y = first; y < last; ++y) {
      const int top = std::max(0, y - kReach), bottom = std::min(height, y + kReach + 1);
      if (where == Where::where_plain) contrasts.find(y, width, contrast.data());
      for (int x = 0; x < width; x += kColumnsAtOnce) {
        const int count = std::min(kColumnsAtOnce, width - x);
        const uint8_t* own = contrast.data() + x;
        if (std::none_of(own, own + count, [](uint8_t c) { return c <= kPlainContrast; })) continue;
        std::array<kernels::SmoothRow, 2 * kReach + 1> window;
        for (int i = top; i < bottom; ++i) window[static_cast<size_t>(i - top)] = rows.at(i, x);
        kernels::best().smooth_row(window.data(), bottom - top, y - top, kWeights.data(), count, smoothed.data());
        for (int i = 0; i < count; ++i)
          if (own[i] <= kPlainContrast && disparity.at(x + i, y) != kNoDisparity)
            out.at(x + i, y) = smoothed[static_cast<size_t>(i)];
      }
    }
  });
  return out;
}

}  // namespace

DisparityMap smooth(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps, const Job& job) {
  const DisparityMap once = smooth_once(disparity, guide, wraps, Where::everywhere, job);
  return smooth_once(once, guide, wraps, Where::where_plain, job);
}

}  // namespace ldp
