#include "core/sweep/cost_volume.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace ldp::sweep {
namespace {

// Parts of the grid that are looked at: strips of columns, cut into square blocks.
constexpr int kBlock = 8, kStrips = 64;

constexpr double kFarthestIn = 1.5;  // times the range's near bound
constexpr int kGlanceLabels = 8, kGlanceSubsteps = 3;

// In 1/kCostScale grey levels: what matches, and by how much less it costs than anything within the range.
constexpr int kMatches = 20, kLess = 10;
constexpr int kMostOfBlock = kBlock * kBlock * 3 / 4;

// Of the blocks looked at. Repeated columns and railings match nearer than they are, but seldom all over a block: in
// 0.01 % of the blocks of atrium_360 and none of the other photo sets'; in 0.38 % of the garden's, where leaves hang at
// half the depth of the nearest point.
constexpr double kLeastShare = 0.002;
constexpr int kLeastBlocks = 4;
constexpr double kHeld = 0.8;  // of the blocks that match nearer

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
    const Costs costs = read(glance_, {x, 0, kBlock, all_depths_.height});
    for (int y = 0; y + kBlock <= all_depths_.height; y += kBlock, ++tally.blocks)
      if (glance_matches(costs, y)) take(x, y, tally);
    return tally;
  }

  double inverse_depth(int label) const {
    return all_depths_.inverse_depth(1.0 * label * kDisparitySteps / (kLabels - 1));
  }

 private:
  static PanoramaGrid widened(PanoramaGrid grid) {
    grid.w_near *= kFarthestIn;
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
    for (int column = 0; column < kBlock; ++column) {
      const uint8_t* cost = strip.data() + (column * all_depths_.height + y) * kGlanceLabels;
      for (int row = 0; row < kBlock; ++row, cost += kGlanceLabels)
        matching += *std::min_element(cost, cost + kGlanceLabels) <= kMatches;
    }
    return matching >= kMostOfBlock;
  }

  // A label is left out between those within the range and those nearer: what matches there may be the bound's own.
  void take(int x, int y, Tally& tally) const {
    const Costs costs = read(sweep_, {x, y, kBlock, kBlock});
    std::vector<int> labels;
    for (auto cost = costs.begin(); cost != costs.end(); cost += kLabels) {
      const int within = *std::min_element(cost, cost + last_within_ + 1);
      const auto nearer = std::min_element(cost + last_within_ + 2, cost + kLabels);
      if (within - *nearer > kLess) labels.push_back(static_cast<int>(nearer - cost));
    }
    if (static_cast<int>(labels.size()) < kMostOfBlock) return;
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
  if (grid.width < kBlock || grid.height < kBlock || grid.w_far >= grid.w_near) return grid.w_near;
  const NearBound bound(frames, grid);
  std::vector<Tally> strips(static_cast<size_t>((grid.width - kBlock) / kStrips + 1));
  parallel_for(job, static_cast<int>(strips.size()),
               [&](int i) { strips[static_cast<size_t>(i)] = bound.strip(i * kStrips); });
  Tally all;
  for (const Tally& strip : strips) {
    all.blocks += strip.blocks;
    for (size_t label = 0; label < all.nearer.size(); ++label) all.nearer[label] += strip.nearer[label];
  }
  const int nearer = std::accumulate(all.nearer.begin(), all.nearer.end(), 0);
  if (nearer < std::max<double>(kLeastBlocks, kLeastShare * all.blocks)) return grid.w_near;
  int label = 0;
  for (int held = all.nearer[0]; held < kHeld * nearer;) held += all.nearer[static_cast<size_t>(++label)];
  return bound.inverse_depth(label);
}

}  // namespace ldp
