#include "core/solve/moves/framed_window.h"

#include <algorithm>

namespace ldp::solve {

namespace {

// Visits every edge between a pixel of the window and one of its ring: body(moving, fixed, of, vertical), where `of` is
// the pixel that owns the edge.
template <typename Body>
void for_ring_edges(const FramedWindow& window, const LabelGrid& grid, const Body& body) {
  const Window& inner = window.inner;
  const int left = window.left_ring, top = window.top_ring, right = left + inner.width, bottom = top + inner.height;
  const auto at = [&](int x, int y) { return x * grid.height + y; };
  for (int x = left; x < right; ++x) {
    if (top > 0) body(at(x, top), at(x, top - 1), at(x, top - 1), true);
    if (bottom < grid.height) body(at(x, bottom - 1), at(x, bottom), at(x, bottom - 1), true);
  }
  for (int y = top; y < bottom; ++y) {
    if (left > 0) body(at(left, y), at(left - 1, y), at(left - 1, y), false);
    if (right < grid.width) body(at(right - 1, y), at(right, y), at(right - 1, y), false);
  }
}

void clear_ring(const FramedWindow& window, LabelGrid& grid) {
  for (int x = 0; x < grid.width; ++x)
    for (int y = 0; y < grid.height; ++y) {
      if (window.inside(x, y)) continue;
      const int p = x * grid.height + y;
      std::fill_n(grid.cost.begin() + static_cast<ptrdiff_t>(p) * kSlots, kSlots, uint16_t{0});
      grid.down[static_cast<size_t>(p)] = grid.right[static_cast<size_t>(p)] = 0;
    }
}

}  // namespace

FramedWindow::FramedWindow(const Window& window, const GridSource& source) : inner(window), outer(window) {
  const bool left = source.wraps() || window.x > 0;
  const bool right = source.wraps() || window.x + window.width < source.width();
  const bool top = window.y > 0, bottom = window.y + window.height < source.height();
  outer.x += left ? (window.x == 0 ? source.width() : 0) - 1 : 0;
  outer.y -= top ? 1 : 0;
  outer.width += (left ? 1 : 0) + (right ? 1 : 0);
  outer.height += (top ? 1 : 0) + (bottom ? 1 : 0);
  left_ring = left ? 1 : 0;
  top_ring = top ? 1 : 0;
}

int64_t fold_ring(const FramedWindow& window, const Smoothness& smoothness, LabelGrid& grid) {
  int64_t energy = 0;
  for_ring_edges(window, grid, [&](int moving, int fixed, int of, bool vertical) {
    uint8_t& factor = vertical ? grid.down[static_cast<size_t>(of)] : grid.right[static_cast<size_t>(of)];
    if (factor == 0) return;
    const int label = grid.label[static_cast<size_t>(fixed)];
    uint16_t* cost = grid.cost.data() + static_cast<ptrdiff_t>(moving) * kSlots;
    for (int slot = 0; slot < kSlots; ++slot)
      cost[slot] = static_cast<uint16_t>(cost[slot] + grid.pair(smoothness, factor, moving, slot, fixed, label));
    energy += grid.pair(smoothness, factor, moving, grid.label[static_cast<size_t>(moving)], fixed, label);
    factor = 0;
  });
  clear_ring(window, grid);
  return energy;
}

int64_t ring_energy(const FramedWindow& window, const GridSource& source, const Smoothness& smoothness,
                    const LabelGrid& grid) {
  int64_t energy = 0;
  for_ring_edges(window, grid, [&](int moving, int fixed, int of, bool vertical) {
    if (!grid.solved[static_cast<size_t>(moving)] || !grid.solved[static_cast<size_t>(fixed)]) return;
    const int x = (window.outer.x + of / grid.height) % source.width(), y = window.outer.y + of % grid.height;
    const int factor = source.edge_factor(x, y, vertical);
    if (factor == 0) return;
    energy += grid.pair(smoothness, factor, moving, grid.label[static_cast<size_t>(moving)], fixed,
                        grid.label[static_cast<size_t>(fixed)]);
  });
  return energy;
}

}  // namespace ldp::solve
