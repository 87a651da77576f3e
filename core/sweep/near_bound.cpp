#include "core/sweep/cost_volume.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/sweep/sweep_tuning.h"

namespace ldp::sweep {
namespace {

using namespace tuning;

using Costs = std::vector<uint8_t>;

struct Tally {
  int blocks = 0;
  std::array<int, kLabels> nearer{};  // blocks by the label at which their median pixel matches best
};

// Sweeps twice: a glance at nearer depths alone, and where those match, one of all depths, nearer ones included.
class NearBound {
 public:
  NearBound(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid)
      : all_depths_(widened(grid)),
        nearer_depths_(nearer(grid)),
        last_within_(
            static_cast<int>((kLabels - 1) * (grid.w_near - grid.w_far) / (all_depths_.w_near - grid.w_far) + 0.25)),
        glance_(frames, nearer_depths_, {}, {}, glancing()),
        sweep_(frames, all_depths_, {}, {}, {}) {}

  Tally strip(int x) const {
    Tally tally;
    const Costs costs = read(glance_, {x, 0, kNearBlock, all_depths_.height});
    for (int y = 0; y + kNearBlock <= all_depths_.height; y += kNearBlock, ++tally.blocks)
      if (glance_matches(costs, y)) take(x, y, tally);
    return tally;
  }

  double inverse_depth(int label) const {
    return all_depths_.inverse_depth(1.0 * label * kDisparitySteps / (kLabels - 1));
  }

 private:
  static PanoramaGrid widened(PanoramaGrid grid) {
    grid.w_near *= kNearFarthestIn;
    return grid;
  }

  static PanoramaGrid nearer(PanoramaGrid grid) {
    grid.w_far = grid.w_near;
    return widened(grid);
  }

  static SweepOptions glancing() {
    SweepOptions options;
    options.labels = kGlanceLabels;
    options.substeps = kGlanceSubsteps;
    return options;
  }

  static Costs read(const CostVolume& sweep, const Window& window) {
    Costs cost(static_cast<size_t>(window.width * window.height * sweep.labels())), grey(cost.size());
    sweep.read(window, cost.data(), grey.data());
    return cost;
  }

  bool glance_matches(const Costs& strip, int y) const {
    int matching = 0;
    for (int column = 0; column < kNearBlock; ++column) {
      const uint8_t* cost = strip.data() + (ptrdiff_t{column} * all_depths_.height + y) * kGlanceLabels;
      for (int row = 0; row < kNearBlock; ++row, cost += kGlanceLabels)
        matching += *std::min_element(cost, cost + kGlanceLabels) <= kNearMatches;
    }
    return matching >= kNearMostOfBlock;
  }

  // A label is left out between those within the range and those nearer: what matches there may be the bound's own.
  void take(int x, int y, Tally& tally) const {
    const Costs costs = read(sweep_, {x, y, kNearBlock, kNearBlock});
    std::vector<int> labels;
    for (auto cost = costs.begin(); cost != costs.end(); cost += kLabels) {
      const int within = *std::min_element(cost, cost + last_within_ + 1);
      const auto nearer = std::min_element(cost + last_within_ + 2, cost + kLabels);
      if (within - *nearer > kNearLess) labels.push_back(static_cast<int>(nearer - cost));
    }
    if (static_cast<int>(labels.size()) < kNearMostOfBlock) return;
    const auto median = labels.begin() + static_cast<std::ptrdiff_t>(labels.size() / 2);
    std::nth_element(labels.begin(), median, labels.end());
    ++tally.nearer[static_cast<size_t>(*median)];
  }

  PanoramaGrid all_depths_, nearer_depths_;
  int last_within_;  // label
  CostVolume glance_, sweep_;
};

}  // namespace
}  // namespace ldp::sweep

namespace ldp {

using namespace sweep;

double matched_near(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid, const Job& job) {
  if (grid.width < kNearBlock || grid.height < kNearBlock || grid.w_far >= grid.w_near) return grid.w_near;
  const NearBound bound(frames, grid);
  std::vector<Tally> strips(static_cast<size_t>((grid.width - kNearBlock) / kNearStripEvery + 1));
  parallel_for(job, static_cast<int>(strips.size()),
               [&](int i) { strips[static_cast<size_t>(i)] = bound.strip(i * kNearStripEvery); });
  Tally all;
  for (const Tally& strip : strips) {
    all.blocks += strip.blocks;
    for (size_t label = 0; label < all.nearer.size(); ++label) all.nearer[label] += strip.nearer[label];
  }
  const int nearer = std::accumulate(all.nearer.begin(), all.nearer.end(), 0);
  if (nearer < std::max<double>(kNearLeastBlocks, kNearLeastShare * all.blocks)) return grid.w_near;
  int label = 0;
  for (int held = all.nearer[0]; held < kNearHeld * nearer;) held += all.nearer[static_cast<size_t>(++label)];
  return bound.inverse_depth(label);
}

}  // namespace ldp
