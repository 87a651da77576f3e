#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "label_grid.h"
#include "smoothness.h"
#include "solve.h"
#include "windows.h"

namespace ldp {

namespace {

int largest_factor(const EdgeFactors* factors) {
  if (factors == nullptr) return 1;
  const auto largest = [](const Plane<uint8_t>& plane) { return *std::ranges::max_element(plane.samples); };
  return std::max<int>({1, largest(factors->right), largest(factors->down)});
}

void check(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options) {
  const auto same_size = [&](const Plane<uint8_t>& plane) {
    return plane.width == costs.width() && plane.height == costs.height();
  };
  if (costs.labels() < 2 || costs.labels() > kSlots) throw std::logic_error("solve_depth: labels must lie in 2 .. 16");
  if (costs.wraps() && costs.width() < 4) throw std::logic_error("solve_depth: a source that wraps is at least 4 wide");
  if (!mask.empty() && !same_size(mask)) throw std::logic_error("solve_depth: mask and costs differ in size");
  if (options.factors != nullptr && !(same_size(options.factors->right) && same_size(options.factors->down)))
    throw std::logic_error("solve_depth: edge factors and costs differ in size");
  if (options.core_px < 8 || options.margin_px < 1 || options.margin_px * 2 + 2 > options.core_px)
    throw std::logic_error("solve_depth: core_px must be at least 8 and above 2 margin_px + 1, margin_px at least 1");
}

// Integer energy units per cost step: as fine as messages of 8 bits allow.
int units_per_cost(const SolveOptions& options) {
  const double widest = options.lambda * kCostScale * options.truncation * largest_factor(options.factors);
  if (!(options.lambda > 0) || options.truncation < 1 || options.truncation > 15 || widest > 255)
    throw std::logic_error("solve_depth: lambda * truncation * factor = " + std::to_string(widest / kCostScale) +
                           " grey levels, must lie in 0 .. 63");
  return std::clamp(static_cast<int>(255 / widest), 1, 16);
}

class DepthSource final : public GridSource {
 public:
  DepthSource(const CostSource& costs, const Plane<uint8_t>& mask, const EdgeFactors* factors, int units)
      : costs_(costs), mask_(mask), factors_(factors), units_(units) {}
  int width() const override { return costs_.width(); }
  int height() const override { return costs_.height(); }
  bool wraps() const override { return costs_.wraps(); }
  int slots() const override { return costs_.labels(); }
  bool has_positions() const override { return false; }

  void load(const Window& window, LabelGrid& grid) const override {
    grid.resize(window.width, window.height, false);
    const auto labels = static_cast<size_t>(costs_.labels());
    const auto n = static_cast<size_t>(grid.size());
    std::vector<uint8_t> cost(n * labels), grey(n * labels);
    costs_.read(window, cost.data(), grey.data());
    for (size_t p = 0; p < n; ++p)
      for (size_t l = 0; l < kSlots; ++l) {
        grid.cost[p * kSlots + l] = l < labels ? static_cast<uint16_t>(cost[p * labels + l] * units_) : kForbidden;
        grid.grey[p * kSlots + l] = l < labels ? grey[p * labels + l] : uint8_t{0};
      }
    for (int x = 0; x < window.width; ++x)
      for (int y = 0; y < window.height; ++y) load_edges(window, x, y, grid);
  }

 private:
  bool solved(int x, int y) const { return mask_.empty() || mask_.at(x, y) != 0; }

  void load_edges(const Window& window, int x, int y, LabelGrid& grid) const {
    const int w = costs_.width();
    const int gx = (window.x + x) % w, gy = window.y + y, next_x = (gx + 1) % w;
    const auto p = static_cast<size_t>(x * window.height + y);
    if (!solved(gx, gy)) {
      std::fill_n(grid.cost.begin() + static_cast<ptrdiff_t>(p) * kSlots, kSlots, uint16_t{0});
      return;
    }
    if (y + 1 < window.height && solved(gx, gy + 1)) grid.down[p] = factors_ ? factors_->down.at(gx, gy) : uint8_t{1};
    if (x + 1 < window.width && solved(next_x, gy)) grid.right[p] = factors_ ? factors_->right.at(gx, gy) : uint8_t{1};
  }

  const CostSource& costs_;
  const Plane<uint8_t>& mask_;
  const EdgeFactors* factors_;
  int units_;
};

}  // namespace

Labelling solve_depth(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options,
                      const Job& job) {
  check(costs, mask, options);
  const int units = units_per_cost(options);
  const int step = std::max(1, static_cast<int>(std::lround(options.lambda * kCostScale * units)));
  const Smoothness smoothness(step, options.contrast, options.truncation);
  const DepthSource source(costs, mask, options.factors, units);
  WindowSolve solve = solve_windows(source, smoothness, options.core_px, options.margin_px, job);
  const double grey_levels = 1.0 / (units * kCostScale);
  Labelling result;
  result.labels = std::move(solve.slots);
  result.report.data_energy = static_cast<double>(solve.final.data) * grey_levels;
  result.report.smoothness_energy = static_cast<double>(solve.final.smoothness) * grey_levels;
  result.report.initial_energy = static_cast<double>(solve.initial.total()) * grey_levels;
  result.report.passes = solve.passes;
  result.report.peak_bytes = solve.peak_bytes;
  return result;
}

}  // namespace ldp
