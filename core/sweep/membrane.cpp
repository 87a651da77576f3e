#include "membrane.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

#include "kernels.h"

namespace ldp {
namespace {

// Chosen on views of photos left out, the same for all (20, 40 and 60 rounds, ties of 5 to 60,
// breaking at an eighth to a whole label, plain up to 12 to 255): redkitchen_arc 23.90 v 23.71 dB and SSIM .839 v .831,
// desk_sweep 21.88 v 21.66 and .853 v .846, kitchen_sideways 24.29 v 24.23 and .822 v .816, atrium_360 21.80 v 21.77,
// courtyard_360 22.59 v 22.61 (SSIM .756 v .754). Ties that break late everywhere draw leaves together (garden 20.58 v
// 20.63 dB).
constexpr int kRounds = 20;
constexpr int kStrongest = 25;  // tie of neighbours of one grey, where firmness is as refine.cpp measures it
constexpr int kDecay = 239;     // of 256: tie that each grey level of difference leaves, exp(-1/15)
constexpr int kContrastReach = 3, kPlainContrast = 24;
constexpr uint8_t kPlain = 128;  // flag of a tie between plain pixels
constexpr int kFraction = 16;    // parts of a disparity step that rounds reckon with
constexpr int kRowsAtOnce = 16;

constexpr std::array<uint8_t, 256> kTies = [] {
  std::array<uint8_t, 256> ties{};
  int tie = kStrongest * 256;
  for (auto& t : ties) {
    t = static_cast<uint8_t>((tie + 128) / 256);
    tie = tie * kDecay / 256;
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
        reach_(plain_reach_ / 6),
        wraps_(wraps),
        job_(job),
        width_(disparity.width),
        height_(disparity.height),
        right_(width_, height_, 0),
        below_(width_, height_, 0),
        now_(width_, height_),
        next_(width_, height_) {
    by_rows([&](int first, int last) { tie(first, last); });
  }

  DisparityMap settled() {
    for (int round = 0; round < kRounds; ++round) {
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
        if (y + 1 < height_) below_.at(x, y) = to(x, y + 1);
      }
  }

  // Where the guide's contrast is low in rows `first` to `end`.
  void find_plain(int first, int end, Plane<uint8_t>& plain) const {
    constexpr int kRows = 2 * kContrastReach + 1;
    const auto padded = static_cast<size_t>(width_ + kernels::kPadding);
    const int above = std::max(0, first - kContrastReach), beyond = std::min(height_, end + kContrastReach);
    std::vector<uint8_t> row(padded + 2 * kContrastReach), contrast(padded);
    std::vector<std::vector<uint8_t>> low, high;
    for (int y = above; y < beyond; ++y) {
      for (int i = 0; i < width_ + 2 * kContrastReach; ++i) {
        const int x = i - kContrastReach;
        row[static_cast<size_t>(i)] = guide_.at(wraps_ ? (x + width_) % width_ : std::clamp(x, 0, width_ - 1), y);
      }
      low.emplace_back(padded);
      high.emplace_back(padded);
      kernels::best().range7(row.data(), width_, low.back().data(), high.back().data());
    }
    for (int y = first; y < end; ++y) {
      kernels::Tinted<const uint8_t> lows[kRows], highs[kRows];
      for (int k = 0; k < kRows; ++k) {
        const auto at = static_cast<size_t>(std::clamp(y + k - kContrastReach, above, beyond - 1) - above);
        lows[k] = {low[at].data(), low[at].data()};
        highs[k] = {high[at].data(), high[at].data()};
      }
      kernels::best().contrast7(lows, highs, width_, contrast.data());
      for (int x = 0; x < width_; ++x) plain.at(x, y - first) = contrast[static_cast<size_t>(x)] <= kPlainContrast;
    }
  }

  void settle_row(int y) {
    const uint16_t *own = now_.row(y), *up = now_.row(y > 0 ? y - 1 : y), *down = now_.row(y + 1 < height_ ? y + 1 : y);
    const uint8_t *right = right_.row(y), *below = below_.row(y), *above = y > 0 ? below_.row(y - 1) : nullptr;
    const uint16_t* held = held_.row(y);
    for (int x = 0; x < width_; ++x) {
      if (held[x] == kNoDisparity) continue;
      const int before = x > 0 ? x - 1 : width_ - 1, after = x + 1 < width_ ? x + 1 : 0;
      uint32_t total = firmness_.at(x, y), sum = total * held[x] * kFraction;
      const auto draw = [&](uint8_t tie, uint16_t towards) {
        const int reach = tie >= kPlain ? plain_reach_ : reach_;
        const uint32_t weight = std::abs(towards - own[x]) <= reach ? tie & (kPlain - 1) : 0;
        sum += weight * towards;
        total += weight;
      };
      draw(right[before], own[before]);
      draw(right[x], own[after]);
      draw(above != nullptr ? above[x] : 0, up[x]);
      draw(below[x], down[x]);
      next_.at(x, y) = total > 0 ? static_cast<uint16_t>((sum + total / 2) / total) : own[x];
    }
  }

  const DisparityMap& held_;
  const Plane<uint8_t>&firmness_, &guide_;
  int plain_reach_, reach_;  // difference at which ties break
  bool wraps_;
  const Job& job_;
  int width_, height_;
  Plane<uint8_t> right_, below_;  // ties; 0 where there is no neighbour
  Plane<uint16_t> now_, next_;    // in parts of a disparity step
};

}  // namespace

DisparityMap weak_membrane(const DisparityMap& disparity, const Plane<uint8_t>& firmness, const Plane<uint8_t>& guide,
                           int label_steps, bool wraps, const Job& job) {
  return Membrane(disparity, firmness, guide, label_steps, wraps, job).settled();
}

}  // namespace ldp
