// The slot that every pixel of a problem takes, and its position where the problem has positions.
#pragma once

#include <cstdint>

#include "core/base/plane.h"
#include "core/solve/moves/framed_window.h"
#include "core/solve/moves/label_grid.h"

namespace ldp::solve {

struct SlotMap {
  Plane<uint8_t> slots, positions;  // positions: empty if the source has none

  explicit SlotMap(const GridSource& source)
      : slots(source.width(), source.height()), positions(source.has_positions() ? slots : Plane<uint8_t>()) {}

  // Pixel p of the terms is (x, y) here.
  void set(int x, int y, uint8_t slot, const PixelTerms& terms, int p) {
    slots.at(x, y) = slot;
    if (!positions.empty()) positions.at(x, y) = static_cast<uint8_t>(terms.position_of(p, slot));
  }

  // Those of a window's own pixels, the grid holding its ring too.
  void store(const FramedWindow& window, const LabelGrid& grid) {
    const Window& inner = window.inner;
    for (int x = 0; x < inner.width; ++x)
      for (int y = 0; y < inner.height; ++y) {
        const int p = (x + window.left_ring) * grid.height + y + window.top_ring;
        set((inner.x + x) % slots.width, inner.y + y, grid.label[static_cast<size_t>(p)], grid, p);
      }
  }
};

// Gives a grid the labels of a window, x modulo the width.
inline void take_labels(const Window& window, const Plane<uint8_t>& slots, LabelGrid& grid) {
  for (int x = 0; x < grid.width; ++x)
    for (int y = 0; y < grid.height; ++y)
      grid.label[static_cast<size_t>(x * grid.height + y)] = slots.at((window.x + x) % slots.width, window.y + y);
}

}  // namespace ldp::solve
