#include "smooth.h"

#include <algorithm>
#include <array>
#include <vector>

namespace ldp {
namespace {

constexpr int kReach = 5;       // of the window: 11 x 11
constexpr int kDecay = 217;     // of 256: weight that each grey level of difference leaves, exp(-1/6)
constexpr int kBinSteps = 128;  // half a label
constexpr int kBins = kDisparitySteps / kBinSteps + 1;
constexpr int kRowsAtOnce = 16;

constexpr std::array<uint8_t, 256> kWeights = [] {
  std::array<uint8_t, 256> weights{};
  int weight = 255 * 256;
  for (auto& w : weights) {
    w = static_cast<uint8_t>(weight / 256);
    weight = weight * kDecay / 256;
  }
  return weights;
}();

struct Tap {
  uint16_t disparity;
  uint8_t weight;
};

// The pixels around one, those without disparity left out.
class Neighbourhood {
 public:
  Neighbourhood(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps)
      : disparity_(disparity), guide_(guide) {
    for (int x = -kReach; x < disparity.width + kReach; ++x) {
      const bool inside = x >= 0 && x < disparity.width;
      columns_.push_back(inside ? x : wraps ? (x + disparity.width) % disparity.width : -1);
    }
  }

  int collect(int x, int y, Tap* taps) const {
    const int grey = guide_.at(x, y);
    const int* columns = columns_.data() + x;
    int count = 0;
    for (int row = std::max(0, y - kReach); row <= std::min(disparity_.height - 1, y + kReach); ++row) {
      const uint16_t* disparities = disparity_.row(row);
      const uint8_t* greys = guide_.row(row);
      for (int i = 0; i <= 2 * kReach; ++i) {
        const int column = columns[i];
        if (column < 0 || disparities[column] == kNoDisparity) continue;
        taps[count++] = {disparities[column], kWeights[static_cast<size_t>(std::abs(greys[column] - grey))]};
      }
    }
    return count;
  }

 private:
  const DisparityMap& disparity_;
  const Plane<uint8_t>& guide_;
  std::vector<int> columns_;  // from -kReach; -1 = there is none
};

int median_bin(const Tap* taps, int count) {
  std::array<int, kBins> weights{};
  int total = 0;
  for (int i = 0; i < count; ++i) {
    weights[taps[i].disparity / kBinSteps] += taps[i].weight;
    total += taps[i].weight;
  }
  int bin = 0;
  for (int below = weights[0]; 2 * below < total; below += weights[static_cast<size_t>(bin)]) ++bin;
  return bin;
}

uint16_t mean_beside(const Tap* taps, int count, int bin) {
  int64_t sum = 0, total = 0;
  for (int i = 0; i < count; ++i) {
    if (std::abs(taps[i].disparity / kBinSteps - bin) > 1) continue;
    sum += int64_t{taps[i].disparity} * taps[i].weight;
    total += taps[i].weight;
  }
  return static_cast<uint16_t>((sum + total / 2) / total);
}

}  // namespace

DisparityMap smooth(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps, const Job& job) {
  DisparityMap out = disparity;
  const Neighbourhood neighbourhood(disparity, guide, wraps);
  parallel_for(job, (disparity.height + kRowsAtOnce - 1) / kRowsAtOnce, [&](int strip) {
    Tap taps[(2 * kReach + 1) * (2 * kReach + 1)];
    for (int y = strip * kRowsAtOnce; y < std::min(disparity.height, (strip + 1) * kRowsAtOnce); ++y)
      for (int x = 0; x < disparity.width; ++x) {
        if (disparity.at(x, y) == kNoDisparity) continue;
        const int count = neighbourhood.collect(x, y, taps);
        out.at(x, y) = mean_beside(taps, count, median_bin(taps, count));
      }
  });
  return out;
}

}  // namespace ldp
