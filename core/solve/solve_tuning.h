// Tuned constants of the solver that are no options (solve.h has those, decisions.md what was measured).
#pragma once

namespace ldp::solve {

// Grids of fewer pixels are small: one unlucky window shows, and more work costs little. They get more iterations of
// message passing and a wider margin, each as numerator over denominator.
constexpr int kSmallPixels = 300000;
constexpr int kSmallIterations[] = {5, 2}, kSmallMargin[] = {3, 2};
constexpr int kSmallPasses = 2;   // of windows where regions do not move; elsewhere 1
constexpr int kRegionCycles = 4;  // of moves over all slots, from 1
constexpr int kCoarseLevels = 3;  // of message passing besides the finest, each at half the resolution; from 0
constexpr int kLoadRows = 400;    // rows of a column of windows loaded at a time, from a window's

}  // namespace ldp::solve
