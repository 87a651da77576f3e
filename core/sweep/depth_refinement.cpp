#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "core/base/job.h"
#include "core/sweep/cost_volume_tables.h"
#include "core/sweep/sweep_tuning.h"
#include "core/sweep/weak_membrane.h"
#include "core/sweep/weighted_median.h"

namespace ldp::sweep {
namespace {

using namespace tuning;

constexpr int kTileWidth = 64, kTileHeight = 256;

constexpr int16_t kNone = 0x7FFF, kNever = -0x4000;

// The smallest window around some pixels.
struct Box {
  int left = 1 << 20, right = 0, top = 1 << 20, bottom = 0;

  bool empty() const { return left >= right; }
  Window window() const { return {left, top, right - left, bottom - top}; }
  void add(const Box& other) {
    left = std::min(left, other.left), right = std::max(right, other.right);
    top = std::min(top, other.top), bottom = std::max(bottom, other.bottom);
  }
};

// Follows, per ray, the costs of its label's fine steps as they come by, nearest last.
class FineMinimum final : public SlabSink {
 public:
  struct Ray {
    int step, best, before, after;
    uint8_t grey;  // of the best
  };

  FineMinimum(const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Window& window) : window_(window) {
    const size_t size = static_cast<size_t>(window.width) * static_cast<size_t>(window.height);
    for (auto* values : {&previous_, &best_, &before_, &after_}) values->assign(size, kNone);
    step_.assign(size, -1);
    grey_.assign(size, 128);
    centre_.reserve(size);
    for (int x = window.x; x < window.x + window.width; ++x)
      for (int y = window.y; y < window.y + window.height; ++y) {
        const bool wanted = mask.empty() || mask.at(x, y) != 0;
        centre_.push_back(wanted ? static_cast<int16_t>(labels.at(x, y) * kFineSteps) : kNever);
        if (wanted) boxes_[labels.at(x, y)].add({x, x + 1, y, y + 1});
      }
  }

  // The rays that want a fine step.
  Box box(int step) const {
    Box box;
    for (int label = 0; label < kLabels; ++label)
      if (std::abs(step - label * kFineSteps) <= kFineReach) box.add(boxes_[static_cast<size_t>(label)]);
    return box;
  }

  void start(int step, const Window& part) {
    now_ = static_cast<int16_t>(step);
    part_ = part;
  }

  void column(int x, const uint16_t* cost, const uint8_t* grey, const uint8_t* /*contrast*/) override {
    const auto at = static_cast<size_t>((part_.x - window_.x + x) * window_.height + part_.y - window_.y);
    const int16_t now = now_, *centre = centre_.data() + at;
    int16_t *previous = previous_.data() + at, *best = best_.data() + at, *before = before_.data() + at,
            *after = after_.data() + at, *step = step_.data() + at, *best_grey = grey_.data() + at;
    for (int y = 0; y < part_.height; ++y) {  // without branches, for vectors
      const auto c = static_cast<int16_t>(cost[y]);
      const bool wanted = centre[y] - kFineReach <= now && centre[y] + kFineReach >= now;
      const bool follows = wanted && step[y] == now - 1, better = wanted && c < best[y];
      after[y] = better ? kNone : follows ? c : after[y];
      before[y] = better ? previous[y] : before[y];
      best[y] = better ? c : best[y];
      step[y] = better ? now : step[y];
      best_grey[y] = better ? grey[y] : best_grey[y];
      previous[y] = wanted ? c : previous[y];
    }
  }

  bool wanted(size_t i) const { return centre_[i] != kNever; }
  Ray ray(size_t i) const { return {step_[i], best_[i], before_[i], after_[i], static_cast<uint8_t>(grey_[i])}; }

 private:
  Window window_, part_;
  int16_t now_ = 0;
  std::array<Box, kLabels> boxes_;  // of the rays of each label
  std::vector<int16_t> centre_;     // fine step of the label
  std::vector<int16_t> previous_, best_, before_, after_, step_, grey_;
};

// Of the parabola through three neighbouring costs; 0 where the least has not both neighbours.
int curvature(const FineMinimum::Ray& ray) {
  return ray.before != kNone && ray.after != kNone ? ray.before + ray.after - 2 * ray.best : 0;
}

// Its lowest point, as disparity.
uint16_t fitted(const FineMinimum::Ray& ray, int fine_steps) {
  int64_t numerator = int64_t{ray.step} * kDisparitySteps, denominator = fine_steps;
  if (const int bend = curvature(ray); bend > 0) {
    numerator = (2 * int64_t{ray.step} * bend + ray.before - ray.after) * kDisparitySteps;
    denominator = 2 * int64_t{bend} * fine_steps;
  }
  return static_cast<uint16_t>(
      std::clamp<int64_t>((2 * numerator + denominator) / (2 * denominator), 0, kDisparitySteps));
}

}  // namespace
}  // namespace ldp::sweep

namespace ldp {

using namespace sweep;

DisparityMap refine(const CostVolume& sweep, const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Job& job) {
  return sweep.refine(labels, mask, job);
}

DisparityMap CostVolume::refine(const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Job& job) const {
  Tables& t = *tables_;
  DisparityMap disparity(labels.width, labels.height, kNoDisparity);
  Plane<uint8_t> grey(labels.width, labels.height), firmness(labels.width, labels.height);
  const int across = (labels.width + kTileWidth - 1) / kTileWidth,
            down = (labels.height + kTileHeight - 1) / kTileHeight;
  const int fine_steps = kFineSteps * (t.options.labels - 1);
  parallel_for(job, across * down, [&](int tile) {
    const int x = tile / down * kTileWidth, y = tile % down * kTileHeight;
    const Window window{x, y, std::min(kTileWidth, labels.width - x), std::min(kTileHeight, labels.height - y)};
    FineMinimum minimum(labels, mask, window);
    auto scratch = t.pool.take();
    scratch->slab.reserve(window.height, t.longest_column);
    for (int step = 0; step <= fine_steps; ++step) {
      const Box box = minimum.box(step);
      if (box.empty()) continue;
      minimum.start(step, box.window());
      const double w = t.grid.inverse_depth(static_cast<double>(step) * kDisparitySteps / fine_steps);
      sweep_slab(t.lines, w, box.window(), t.options.prior_cost, false, scratch->slab, minimum);
    }
    t.pool.give_back(std::move(scratch));
    size_t i = 0;
    for (int column = x; column < x + window.width; ++column)
      for (int row = y; row < y + window.height; ++row, ++i) {
        if (!minimum.wanted(i)) continue;
        disparity.at(column, row) = fitted(minimum.ray(i), fine_steps);
        grey.at(column, row) = minimum.ray(i).grey;
        firmness.at(column, row) = static_cast<uint8_t>(std::clamp(curvature(minimum.ray(i)), 0, 255));
      }
  });
  disparity = smooth(disparity, grey, t.grid.wraps, job);
  return weak_membrane(disparity, firmness, grey, kDisparitySteps / (t.options.labels - 1), t.grid.wraps, job);
}

}  // namespace ldp
