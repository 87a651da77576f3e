#include "core/solve/window_scratch.h"

namespace ldp::solve {

namespace {

void exchange(LabelGrid& grid, const Smoothness& smoothness, int iterations, const Job& job) {
  const KernelGrid kernel_grid = grid.kernel_grid(smoothness);
  for (int i = 0; i < iterations; ++i) {
    job.check();
    message_kernels().sweep(kernel_grid, true, 0, grid.width);
    message_kernels().sweep(kernel_grid, false, 0, grid.width);
  }
}

}  // namespace

bool WindowScratch::solve(const Smoothness& smoothness, int slots, const Effort& effort, const Job& job) {
  bool changed = effort.iterations > 0 && pass_messages(smoothness, effort.iterations, job);
  if (expand(smoothness, slots, effort.cycles, job)) changed = true;
  return changed;
}

// Message passing leaves its reparametrisation in the grid; its labels are taken if they are no worse.
bool WindowScratch::pass_messages(const Smoothness& smoothness, int iterations, const Job& job) {
  const int64_t energy = energy_of(grid, smoothness).total();
  labels_ = grid.label;
  const LabelGrid* finer = &grid;
  for (LabelGrid& level : coarse_) {
    coarsen(*finer, level);
    finer = &level;
  }
  for (int i = kCoarseLevels; i-- > 0;) {
    LabelGrid& level = coarse_[static_cast<size_t>(i)];
    exchange(level, smoothness, iterations, job);
    spread_messages(level, i == 0 ? grid : coarse_[static_cast<size_t>(i - 1)]);
  }
  exchange(grid, smoothness, (3 * iterations + 3) / 4, job);  // the coarse start saves a quarter of them
  message_kernels().decide(grid.kernel_grid(smoothness));
  if (energy_of(grid, smoothness).total() < energy) return true;
  grid.label = labels_;
  return false;
}

bool WindowScratch::expand(const Smoothness& smoothness, int slots, int cycles, const Job& job) {
  if (cycles == 0) return false;
  bool changed = false;
  expansion_.start(grid, smoothness);
  for (int cycle = 0; cycle < cycles; ++cycle) {
    bool pending = false;
    for (int alpha = 0; alpha < slots; ++alpha) {
      job.check();
      if (!expansion_.pending(alpha)) continue;
      pending = true;
      if (expansion_.expand(alpha)) changed = true;
    }
    if (!pending) break;
  }
  return changed;
}

size_t WindowScratch::bytes() const {
  size_t sum = labels_.capacity() + grid.bytes() + expansion_.bytes();
  for (const LabelGrid& level : coarse_) sum += level.bytes();
  return sum;
}

}  // namespace ldp::solve
