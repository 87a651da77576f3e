// A window of a grid with a ring of fixed pixels around it, where the grid goes on.
#pragma once

#include "core/base/cost_source.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/smoothness.h"

namespace ldp::solve {

struct FramedWindow {
  Window inner, outer;
  int left_ring = 0, top_ring = 0;

  FramedWindow(const Window& window, const GridSource& source);
  bool inside(int x, int y) const {
    return x >= left_ring && y >= top_ring && x < left_ring + inner.width && y < top_ring + inner.height;
  }
};

// Turns edges to the fixed pixels of the ring into unary costs and removes them; the ring itself has nothing to choose.
// The grid holds `outer`. Gives the pair terms of the edges folded, of the labels now.
int64_t fold_ring(const FramedWindow& window, const Smoothness& smoothness, LabelGrid& grid);

// The pair terms of the edges that `fold_ring` removed, of other labels.
int64_t ring_energy(const FramedWindow& window, const GridSource& source, const Smoothness& smoothness,
                    const LabelGrid& grid);

}  // namespace ldp::solve
