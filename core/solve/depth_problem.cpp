#include "depth_problem.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

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

int checked_units(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options) {
  check(costs, mask, options);
  const double widest = options.lambda * kCostScale * options.truncation * largest_factor(options.factors);
  if (!(options.lambda > 0) || options.truncation < 1 || options.truncation > 15 || widest > kWidestPair)
    throw std::logic_error("solve_depth: lambda * truncation * factor = " + std::to_string(widest / kCostScale) +
                           " grey levels, must lie in 0 .. 62");
  return std::clamp(static_cast<int>(kWidestPair / widest), 1, 16);
}

int step_of(const SolveOptions& options, int units) {
  return std::max(1, static_cast<int>(std::lround(options.lambda * kCostScale * units)));
}

}  // namespace

void DepthSource::load(const Window& window, LabelGrid& grid) const {
  grid.resize(window.width, window.height, false);
  const auto labels = static_cast<size_t>(costs_.labels());
  const auto n = static_cast<size_t>(grid.size());
  std::vector<uint8_t> cost(n * labels), grey(n * labels);
  costs_.read(window, cost.data(), grey.data());
  for (size_t p = 0; p < n; ++p)
    for (size_t l = 0; l < kSlots; ++l) {
      grid.cost[p * kSlots + l] = l < labels ? static_cast<uint16_t>(cost[p * labels + l] * units_) : kForbidden;
      grid.grey[p * kSlots + l] = l < labels ? grey[p * labels + l] : grey[p * labels + labels - 1];
    }
  for (int x = 0; x < window.width; ++x)
    for (int y = 0; y < window.height; ++y) load_edges(window, x, y, grid);
  grid.find_grey_ranges();
}

void DepthSource::load_edges(const Window& window, int x, int y, LabelGrid& grid) const {
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

DepthProblem::DepthProblem(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options)
    : units_(checked_units(costs, mask, options)),
      smoothness_(step_of(options, units_), options.contrast, options.truncation, largest_factor(options.factors)),
      source_(costs, mask, options.factors, units_) {}

}  // namespace ldp
