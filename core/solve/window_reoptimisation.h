// Solves again the windows of a grid in which regions moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/base/scratch_pool.h"
#include "core/solve/moves/framed_window.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/slot_map.h"
#include "core/solve/moves/smoothness.h"
#include "core/solve/tiling.h"
#include "core/solve/window_scratch.h"

namespace ldp::solve {

class WindowReoptimisation {
 public:
  // `before`: the slots before regions moved; `slot_map`: those since. `all`: windows that no region touched, too.
  WindowReoptimisation(const GridSource& source, const Smoothness& smoothness, const WindowTiling& tiling,
                       const Effort& effort, bool all, Plane<uint8_t> before, SlotMap& slot_map);

  // Gives by how much the energy rose since `before`.
  Energy run(const Job& job);

  size_t bytes() const { return before_.samples.capacity() + moved_.samples.capacity() + pool_.bytes(); }

 private:
  struct Cell {
    Interval column, row;
  };

  size_t class_of(size_t interval) const;
  bool touched(const Cell& cell) const;
  bool worth_reoptimising(const Window& outer, const LabelGrid& grid) const;
  Energy reoptimise(const Cell& cell, const Job& job);
  Energy solve_again(const FramedWindow& window, WindowScratch& scratch, const Job& job);
  Energy core_energy(const Cell& cell, const Window& outer, const LabelGrid& grid) const;

  const GridSource& source_;
  const Smoothness& smoothness_;
  const WindowTiling& tiling_;
  const Effort effort_;
  const bool all_;
  const Plane<uint8_t> before_, moved_;  // slots before and after regions moved
  SlotMap& slot_map_;
  ScratchPool<WindowScratch> pool_;
};

}  // namespace ldp::solve
