// Solves a labelling problem of any size window by window: each window's labels are improved with everything outside
// it held fixed, so that the energy of the whole never rises. The grid is walked through in strips of columns; of the
// windows of a strip every second one is solved at a time, in parallel, with the same result in any order. Then regions
// larger than windows move, and the windows that this touched are loaded and solved once more.
#pragma once

#include <cstddef>
#include <cstdint>

#include "job.h"
#include "label_grid.h"
#include "plane.h"
#include "smoothness.h"

namespace ldp {

struct WindowOptions {  // as SolveOptions has them
  int core_px, margin_px, iterations, cycles, passes, settling_cycles = 0;
};

struct WindowSolve {
  Plane<uint8_t> slots;
  Plane<uint8_t> positions;  // of the slots; empty if the source has none
  Energy initial, final;     // of the cheapest slot of every pixel, and of the result
  int passes = 0;
  size_t peak_bytes = 0;
};

WindowSolve solve_windows(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options,
                          const Job& job);

}  // namespace ldp
