#include "core/solve/depth_problem.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace ldp::solve {

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

// The rows between the first and the last pixel that is part of the problem.
Window DepthSource::solved_part(const Window& window) const {
  int first = window.y + window.height, last = window.y - 1;
  for (int x = 0; x < window.width; ++x) {
    const int column = (window.x + x) % costs_.width();
    int top = window.y, bottom = window.y + window.height - 1;
    while (top < first && !solved(column, top)) ++top;
    while (bottom > last && !solved(column, bottom)) --bottom;
    first = std::min(first, top);
    last = std::max(last, bottom);
  }
  return {window.x, first, window.width, std::max(0, last - first + 1)};
}

// Where every slot is a label, in vectors.
void DepthSource::take_all(const uint8_t* cost, const uint8_t* grey, size_t p, PixelTerms& terms) const {
  uint16_t* to = terms.cost.data() + p * kSlots;
  for (int l = 0; l < kSlots; ++l) to[l] = static_cast<uint16_t>(cost[l] * units_);
  std::copy_n(grey, kSlots, terms.grey.data() + p * kSlots);
}

void DepthSource::load(const Window& window, PixelTerms& terms, int first) const {
  for (int x = 0; x < window.width; ++x) {
    const ptrdiff_t p = first + ptrdiff_t{x} * terms.height;
    std::fill_n(terms.cost.begin() + p * kSlots, window.height * kSlots, uint16_t{0});
    std::fill_n(terms.grey.begin() + p * kSlots, window.height * kSlots, uint8_t{0});
    std::fill_n(terms.solved.begin() + p, window.height, uint8_t{0});
  }
  const Window part = solved_part(window);
  if (part.height == 0) return;
  const auto labels = static_cast<size_t>(costs_.labels());
  std::vector<uint8_t> cost(static_cast<size_t>(part.width * part.height) * labels), grey(cost.size());
  costs_.read(part, cost.data(), grey.data());
  for (int x = 0; x < part.width; ++x)
    for (int y = 0; y < part.height; ++y) {
      if (!solved((part.x + x) % costs_.width(), part.y + y)) continue;
      const auto p = static_cast<size_t>(first + x * terms.height + part.y - window.y + y);
      const size_t from = static_cast<size_t>(x * part.height + y) * labels;
      terms.solved[p] = 1;
      if (labels == kSlots) {
        take_all(cost.data() + from, grey.data() + from, p, terms);
        continue;
      }
      for (size_t l = 0; l < kSlots; ++l) {
        terms.cost[p * kSlots + l] = l < labels ? static_cast<uint16_t>(cost[from + l] * units_) : kForbidden;
        terms.grey[p * kSlots + l] = grey[from + std::min(l, labels - 1)];
      }
    }
}

DepthProblem::DepthProblem(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options)
    : units_(checked_units(costs, mask, options)),
      smoothness_(step_of(options, units_), options.contrast, options.truncation, largest_factor(options.factors)),
      source_(costs, mask, options.factors, units_) {}

}  // namespace ldp::solve
