// What a thread needs to work on one window; kept for the next window.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/solve/moves/alpha_expansion.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/smoothness.h"
#include "core/solve/solve_tuning.h"

namespace ldp::solve {

struct Effort {
  int iterations, cycles;  // of message passing and of expansion
};

class WindowScratch {
 public:
  LabelGrid grid;  // the window, its ring folded

  // Improves the grid's labels by message passing and expansion; true if they changed. The grid's energy never rises.
  bool solve(const Smoothness& smoothness, int slots, const Effort& effort, const Job& job);

  size_t bytes() const;

 private:
  bool pass_messages(const Smoothness& smoothness, int iterations, const Job& job);
  bool expand(const Smoothness& smoothness, int slots, int cycles, const Job& job);

  std::array<LabelGrid, kCoarseLevels> coarse_;  // the window at 1/2, 1/4 ... of its resolution
  Expansion expansion_;
  std::vector<uint8_t> labels_;
};

}  // namespace ldp::solve
