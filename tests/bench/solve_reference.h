// What the solver is measured against: plain alpha-expansion on the whole grid, and a lower bound by tree-reweighted
// message passing (Kolmogorov 2006) in floating point. Slow and large on purpose.
#pragma once

#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/smoothness.h"

namespace ldp::solve {

// From slot 0 everywhere, cycles over all slots until none changes a label. The grid's messages must be zero.
void expand_whole_grid(LabelGrid& grid, const Smoothness& smoothness, int slots);

// Lower bound of the energy of any labelling of the grid, after so many iterations, or fewer where it has converged.
double lower_bound(const LabelGrid& grid, const Smoothness& smoothness, int iterations);

}  // namespace ldp::solve
