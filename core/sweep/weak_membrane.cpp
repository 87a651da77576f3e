#include "core/sweep/weak_membrane.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

#include "core/sweep/sweep_kernels.h"
#include "core/sweep/sweep_tuning.h"

namespace ldp::sweep {
namespace {

using namespace tuning;

constexpr uint8_t kPlain = 128;  // flag of a tie between plain pixels
constexpr int kFraction = 8;     // parts of a disparity step that rounds reckon with
constexpr int kRowsAtOnce = 16;
constexpr float kHalf = 0.5F;

constexpr std::array<uint8_t, 256> kTies = [] {
  std::array<uint8_t, 256> ties{};
  int tie = kStrongestTie * 256;
  for (auto& t : ties) {
    t = static_cast<uint8_t>((tie + 128) / 256);
    tie = tie * kTieDecay / 256;
  }
  return ties;
}();

class Membrane {
 public:
  Membrane(const DisparityMap& disparity, const Plane<uint8_t>& firmness, const Plane<uint8_t>& guide, int label_steps,
           bool wraps, const Job& job)
      : held_(disparity),
        firmness_(firmness),
        guide_(guide),
        plain_reach_(label_steps * kFraction),
        reach_(plain_reach_ / kLabelBreaks),
        wraps_(wraps),
        job_(job),
        width_(disparity.width),
        height_(disparity.height),
        right_(width_, height_, 0),
        above_(width_, height_ + 1, 0),
        now_(width_, height_),
        next_(width_, height_) {
    by_rows([&](int first, int last) { tie(first, last); });
  }

  DisparityMap settled() {
    for (int round = 0; round < kMembraneRounds; ++round) {
      by_rows([&](int first, int last) {
        for (int y = first; y < last; ++y) settle_row(y);
      });
      std::swap(now_, next_);
    }
    DisparityMap out(width_, height_, kNoDisparity);
    for (size_t i = 0; i < out.samples.size(); ++i)
      if (held_.samples[i] != kNoDisparity)
        out.samples[i] = static_cast<uint16_t>((now_.samples[i] + kFraction / 2) / kFraction);
    return out;
  }

 private:
  template <typename Body>
  void by_rows(const Body& body) const {
    parallel_for(job_, (height_ + kRowsAtOnce - 1) / kRowsAtOnce,
                 [&](int strip) { body(strip * kRowsAtOnce, std::min(height_, (strip + 1) * kRowsAtOnce)); });
  }

  // The ties of some rows to the right and to the row below each, and where their rounds begin.
  void tie(int first, int last) {
    const int end = std::min(height_, last + 1);
    Plane<uint8_t> plain(width_, end - first);
    find_plain(first, end, plain);
    for (int y = first; y < last; ++y)
      for (int x = 0; x < width_; ++x) {
        if (held_.at(x, y) == kNoDisparity) continue;
        now_.at(x, y) = static_cast<uint16_t>(held_.at(x, y) * kFraction);
        const auto to = [&](int nx, int ny) -> uint8_t {
          if (held_.at(nx, ny) == kNoDisparity) return 0;
          const uint8_t tie = kTies[static_cast<size_t>(std::abs(guide_.at(x, y) - guide_.at(nx, ny)))];
          return plain.at(x, y - first) && plain.at(nx, ny - first) ? tie | kPlain : tie;
        };
        if (x + 1 < width_ || wraps_) right_.at(x, y) = to(x + 1 < width_ ? x + 1 : 0, y);
        if (y + 1 < height_) above_.at(x, y + 1) = to(x, y + 1);
      }
  }

  // Where the contrast of the guide's present pixels is low in rows `first` to `end`.
  void find_plain(int first, int end, Plane<uint8_t>& plain) const {
    constexpr int kRows = 2 * kMembraneContrastReach + 1;
    const auto padded = static_cast<size_t>(width_ + kernels::kPadding);
    const int above = std::max(0, first - kMembraneContrastReach),
              beyond = std::min(height_, end + kMembraneContrastReach);
    std::vector<uint8_t> darkest(padded + size_t{2} * kMembraneContrastReach), brightest = darkest, contrast(padded),
                                                                               unused(padded);
    std::vector<std::vector<uint8_t>> low, high;
    for (int y = above; y < beyond; ++y) {
      for (int i = 0; i < width_ + 2 * kMembraneContrastReach; ++i) {
        const int beside = i - kMembraneContrastReach,
                  x = wraps_ ? (beside + width_) % width_ : std::clamp(beside, 0, width_ - 1);
        const bool present = held_.at(x, y) != kNoDisparity;
        darkest[static_cast<size_t>(i)] = present ? guide_.at(x, y) : uint8_t{255};
        brightest[static_cast<size_t>(i)] = present ? guide_.at(x, y) : uint8_t{0};
      }
      low.emplace_back(padded);
      high.emplace_back(padded);
      kernels::best().range7(darkest.data(), width_, low.back().data(), unused.data());
      kernels::best().range7(brightest.data(), width_, unused.data(), high.back().data());
    }
    for (int y = first; y < end; ++y) {
      kernels::Tinted<const uint8_t> lows[kRows], highs[kRows];
      for (int k = 0; k < kRows; ++k) {
        const auto at = static_cast<size_t>(std::clamp(y + k - kMembraneContrastReach, above, beyond - 1) - above);
        lows[k] = {low[at].data(), low[at].data()};
        highs[k] = {high[at].data(), high[at].data()};
      }
      kernels::best().contrast7(lows, highs, width_, contrast.data());
      for (int x = 0; x < width_; ++x)
        plain.at(x, y - first) = contrast[static_cast<size_t>(x)] <= kMembranePlainContrast;
    }
  }

  void settle_row(int y) {
    const Row row{now_.row(y),
                  now_.row(std::max(0, y - 1)),
                  now_.row(std::min(height_ - 1, y + 1)),
                  held_.row(y),
                  firmness_.row(y),
                  right_.row(y),
                  above_.row(y),
                  above_.row(y + 1),
                  reach_,
                  plain_reach_ - reach_,
                  next_.row(y)};
    row.settle(0, width_ - 1, std::min(1, width_ - 1));
    for (int x = 1; x < width_ - 1; ++x) row.settle(x, x - 1, x + 1);
    if (width_ > 1) row.settle(width_ - 1, width_ - 2, 0);
  }

  // What a round looks at in one row.
  struct Row {
    static_assert((255 + 4 * kStrongestTie) * kDisparitySteps * kFraction < 1 << 24);
    const uint16_t *own, *up, *down, *held;
    const uint8_t *firmness, *right, *above, *below;
    int reach, more_where_plain;
    uint16_t* next;

    // Without branches, for vectors; nobody is tied to what absent pixels come to. Floats hold the sums exactly.
    void settle(int x, int before, int after) const {
      int total = firmness[x], sum = total * held[x] * kFraction;
      const auto draw = [&](int tie, int towards) {
        const int apart = towards > own[x] ? towards - own[x] : own[x] - towards;
        const int bears = reach + (tie >> 7) * more_where_plain, weight = apart <= bears ? tie & (kPlain - 1) : 0;
        sum += weight * towards;
        total += weight;
      };
      draw(right[before], own[before]);
      draw(right[x], own[after]);
      draw(above[x], up[x]);
      draw(below[x], down[x]);
      const int free = total == 0;  // stays where it is
      sum += free * own[x];
      total += free;
      const float mean = static_cast<float>(sum) / static_cast<float>(total);
      next[x] = static_cast<uint16_t>(static_cast<int>(mean + kHalf));  // rounded, in vectors
    }
  };

  const DisparityMap& held_;
  const Plane<uint8_t>&firmness_, &guide_;
  int plain_reach_, reach_;  // difference at which ties break
  bool wraps_;
  const Job& job_;
  int width_, height_;
  Plane<uint8_t> right_,
      above_;                   // ties to the pixel on the right, to the one above (a row more); 0 where there is none
  Plane<uint16_t> now_, next_;  // in parts of a disparity step
};

}  // namespace

DisparityMap weak_membrane(const DisparityMap& disparity, const Plane<uint8_t>& firmness, const Plane<uint8_t>& guide,
                           int label_steps, bool wraps, const Job& job) {
  return Membrane(disparity, firmness, guide, label_steps, wraps, job).settled();
}

}  // namespace ldp::sweep
