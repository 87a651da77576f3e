// Solves a labelling problem of any size window by window: each window's labels are improved with everything outside
// it held fixed, so that the energy of the whole never rises (window_pass.h). Then regions larger than windows move
// (region_moves.h).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/job.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/slot_map.h"
#include "core/solve/moves/smoothness.h"
#include "core/solve/solve.h"

namespace ldp::solve {

struct WindowOptions {  // as SolveOptions has them
  int core_px, margin_px, iterations, cycles, passes;
};

struct WindowSolve {
  explicit WindowSolve(const GridSource& source) : slot_map(source) {}

  SlotMap slot_map;
  Energy initial, final;  // of the cheapest slot of every pixel, and of the result
  int passes = 0;
  size_t peak_bytes = 0;
};

// The report of a solve, an energy unit being worth so much.
SolveReport report_of(const WindowSolve& solve, double per_unit);

WindowSolve solve_windows(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options,
                          const Job& job);

}  // namespace ldp::solve
