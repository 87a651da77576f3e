// The depth problem in integers: a cost source and options as a grid source and a smoothness table.
#pragma once

#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/smoothness.h"
#include "core/solve/solve.h"

namespace ldp::solve {

class DepthSource final : public GridSource {
 public:
  DepthSource(const CostSource& costs, const Plane<uint8_t>& mask, const EdgeFactors* factors, int units)
      : costs_(costs), mask_(mask), factors_(factors), units_(units) {}
  int width() const override { return costs_.width(); }
  int height() const override { return costs_.height(); }
  bool wraps() const override { return costs_.wraps(); }
  int slots() const override { return costs_.labels(); }
  bool has_positions() const override { return false; }

  int edge_factor(int x, int y, bool down) const override {
    return factors_ ? (down ? factors_->down : factors_->right).at(x, y) : 1;
  }
  void load(const Window& window, PixelTerms& terms, int first) const override;

 private:
  bool solved(int x, int y) const { return mask_.empty() || mask_.at(x, y) != 0; }
  void take_all(const uint8_t* cost, const uint8_t* grey, size_t p, PixelTerms& terms) const;
  Window solved_part(const Window& window) const;

  const CostSource& costs_;
  const Plane<uint8_t>& mask_;
  const EdgeFactors* factors_;
  int units_;
};

class DepthProblem {
 public:
  // Checks the options; what is passed must outlive the problem.
  DepthProblem(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options);

  const GridSource& source() const { return source_; }
  const Smoothness& smoothness() const { return smoothness_; }
  double grey_levels_per_unit() const { return 1.0 / (units_ * kCostScale); }

 private:
  int units_;  // energy units per cost step: as fine as messages of 8 bits allow
  Smoothness smoothness_;
  DepthSource source_;
};

}  // namespace ldp::solve
