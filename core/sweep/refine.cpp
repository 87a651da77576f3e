#include <algorithm>
#include <set>

#include "job.h"
#include "smooth.h"
#include "tables.h"

namespace ldp {
namespace {

constexpr int kFine = 8;   // fine steps a label
constexpr int kReach = 6;  // fine steps either side of the label's middle that are tried
constexpr int kTile = 64;

// Follows, per ray, the costs of its label's fine steps as they come by, nearest last.
class FineMinimum final : public SlabSink {
 public:
  struct Ray {
    int centre = 0;  // fine step of the label
    uint16_t previous = 0xFFFF, best = 0xFFFF, before = 0xFFFF, after = 0xFFFF;
    int16_t step = -1;
    uint8_t grey = 128;  // of the best
    bool wanted = true;
  };

  FineMinimum(const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Window& window) : height_(window.height) {
    for (int x = window.x; x < window.x + window.width; ++x)
      for (int y = window.y; y < window.y + window.height; ++y) {
        Ray& ray = rays_.emplace_back();
        ray.centre = labels.at(x, y) * kFine;
        ray.wanted = mask.empty() || mask.at(x, y) != 0;
      }
  }
  void start(int step) { step_ = step; }
  void column(int x, const uint16_t* cost, const uint8_t* grey) override {
    Ray* ray = rays_.data() + static_cast<size_t>(x) * static_cast<size_t>(height_);
    for (int y = 0; y < height_; ++y, ++ray) {
      if (std::abs(step_ - ray->centre) > kReach) continue;
      if (ray->step == step_ - 1) ray->after = cost[y];
      if (cost[y] < ray->best) {
        ray->best = cost[y];
        ray->before = ray->previous;
        ray->after = 0xFFFF;
        ray->step = static_cast<int16_t>(step_);
        ray->grey = grey[y];
      }
      ray->previous = cost[y];
    }
  }
  const std::vector<Ray>& rays() const { return rays_; }

 private:
  std::vector<Ray> rays_;
  int height_, step_ = 0;
};

// Lowest point of the parabola through three neighbouring costs, as disparity.
uint16_t fitted(const FineMinimum::Ray& ray, int fine_steps) {
  int64_t numerator = int64_t{ray.step} * kDisparitySteps, denominator = fine_steps;
  if (ray.before != 0xFFFF && ray.after != 0xFFFF) {
    const int curvature = ray.before + ray.after - 2 * ray.best;
    if (curvature > 0) {
      numerator = (2 * int64_t{ray.step} * curvature + ray.before - ray.after) * kDisparitySteps;
      denominator = 2 * int64_t{curvature} * fine_steps;
    }
  }
  return static_cast<uint16_t>(
      std::clamp<int64_t>((2 * numerator + denominator) / (2 * denominator), 0, kDisparitySteps));
}

std::set<int> steps_wanted(const FineMinimum& minimum, int fine_steps) {
  std::set<int> centres, steps;
  for (const auto& ray : minimum.rays())
    if (ray.wanted) centres.insert(ray.centre);
  for (const int centre : centres) {
    for (int s = std::max(0, centre - kReach); s <= std::min(fine_steps, centre + kReach); ++s) steps.insert(s);
  }
  return steps;
}

}  // namespace

DisparityMap refine(const Sweep& sweep, const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Job& job) {
  return sweep.refine(labels, mask, job);
}

DisparityMap Sweep::refine(const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Job& job) const {
  Tables& t = *tables_;
  DisparityMap disparity(labels.width, labels.height, kNoDisparity);
  Plane<uint8_t> grey(labels.width, labels.height);
  const int across = (labels.width + kTile - 1) / kTile, down = (labels.height + kTile - 1) / kTile;
  const int fine_steps = kFine * (t.options.labels - 1);
  parallel_for(job, across * down, [&](int tile) {
    const int x = tile / down * kTile, y = tile % down * kTile;
    const Window window{x, y, std::min(kTile, labels.width - x), std::min(kTile, labels.height - y)};
    FineMinimum minimum(labels, mask, window);
    auto scratch = t.take_scratch();
    scratch->slab.reserve(window.height, t.longest_column);
    for (const int step : steps_wanted(minimum, fine_steps)) {
      minimum.start(step);
      const double w = t.grid.inverse_depth(static_cast<double>(step) * kDisparitySteps / fine_steps);
      sweep_slab(t.lines, w, window, t.options.prior_cost, scratch->slab, minimum);
    }
    t.give_back(std::move(scratch));
    const auto* ray = minimum.rays().data();
    for (int i = 0; i < window.width; ++i)
      for (int j = 0; j < window.height; ++j, ++ray) {
        if (!ray->wanted) continue;
        disparity.at(x + i, y + j) = fitted(*ray, fine_steps);
        grey.at(x + i, y + j) = ray->grey;
      }
  });
  return smooth(disparity, grey, t.grid.wraps, job);
}

}  // namespace ldp
