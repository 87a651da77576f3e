#include "core/solve/window_reoptimisation.h"

#include <algorithm>
#include <utility>

namespace ldp::solve {

namespace {

size_t at(int i) { return static_cast<size_t>(i); }

}  // namespace

WindowReoptimisation::WindowReoptimisation(const GridSource& source, const Smoothness& smoothness,
                                           const WindowTiling& tiling, const Effort& effort, bool all,
                                           Plane<uint8_t> before, SlotMap& slot_map)
    : source_(source),
      smoothness_(smoothness),
      tiling_(tiling),
      effort_(effort),
      all_(all),
      before_(std::move(before)),
      moved_(slot_map.slots),
      slot_map_(slot_map) {}

Energy WindowReoptimisation::run(const Job& job) {
  Energy sum;
  for (size_t class_x = 0; class_x < 3; ++class_x)
    for (size_t class_y = 0; class_y < 2; ++class_y) {
      std::vector<Cell> cells;
      for (size_t i = 0; i < tiling_.columns.size(); ++i)
        for (size_t j = class_y; j < tiling_.rows.size(); j += 2)
          if (const Cell cell{tiling_.columns[i], tiling_.rows[j]}; class_of(i) == class_x && (all_ || touched(cell)))
            cells.push_back(cell);
      std::vector<Energy> rises(cells.size());
      parallel_for(job, static_cast<int>(cells.size()), [&](int i) { rises[at(i)] = reoptimise(cells[at(i)], job); });
      for (const Energy& rise : rises) sum += rise;
    }
  return sum;
}

// Windows of one class share no edge. On a ring of an odd number of intervals the last is next to the first.
size_t WindowReoptimisation::class_of(size_t interval) const {
  const size_t count = tiling_.columns.size();
  return source_.wraps() && count % 2 == 1 && interval + 1 == count ? 2 : interval % 2;
}

// Whether a core or the pixels next to it changed.
bool WindowReoptimisation::touched(const Cell& cell) const {
  const int top = std::max(0, cell.row.core_begin - 1),
            bottom = std::min(source_.height(), cell.row.core_begin + cell.row.core_size + 1);
  for (int i = -1; i <= cell.column.core_size; ++i) {
    const int x = cell.column.core_begin + i;
    if (!source_.wraps() && (x < 0 || x >= source_.width())) continue;
    const int wrapped = (x + source_.width()) % source_.width();
    for (int y = top; y < bottom; ++y)
      if (before_.at(wrapped, y) != moved_.at(wrapped, y)) return true;
  }
  return false;
}

// Solves a window again. Gives by how much the energy of its core's pixels and edges rose when regions moved, and that
// of the window since then.
Energy WindowReoptimisation::reoptimise(const Cell& cell, const Job& job) {
  const FramedWindow window({cell.column.begin, cell.row.begin, cell.column.size, cell.row.size}, source_);
  auto scratch = pool_.take();
  LabelGrid& grid = scratch->grid;
  grid.resize(window.outer.width, window.outer.height, false);
  source_.load(window.outer, grid, 0);
  grid.find_grey_ranges();
  set_edges(source_, window.outer, grid);
  take_labels(window.outer, moved_, grid);
  Energy rise = core_energy(cell, window.outer, grid);
  take_labels(window.outer, before_, grid);
  rise -= core_energy(cell, window.outer, grid);
  take_labels(window.outer, slot_map_.slots, grid);
  if (all_ || worth_reoptimising(window.outer, grid)) rise += solve_again(window, *scratch, job);
  pool_.give_back(std::move(scratch));
  return rise;
}

// Whether a label that a region took meets another label in a window.
bool WindowReoptimisation::worth_reoptimising(const Window& outer, const LabelGrid& grid) const {
  for (int x = 0; x < grid.width; ++x)
    for (int y = 0; y < grid.height; ++y) {
      const int column = (outer.x + x) % source_.width(), p = x * grid.height + y;
      if (before_.at(column, outer.y + y) == moved_.at(column, outer.y + y)) continue;
      for (int direction = 0; direction < 4; ++direction)
        if (grid.factor(p, direction) != 0 && grid.label[at(p)] != grid.label[at(p + grid.stride(direction))])
          return true;
    }
  return false;
}

Energy WindowReoptimisation::solve_again(const FramedWindow& window, WindowScratch& scratch, const Job& job) {
  LabelGrid& grid = scratch.grid;
  const auto with_ring = [&](int64_t ring) {  // ring: pair terms that became data terms
    Energy energy = energy_of(grid, smoothness_);
    energy.data -= ring;
    energy.smoothness += ring;
    return energy;
  };
  const Energy before = with_ring(fold_ring(window, smoothness_, grid));
  if (!scratch.solve(smoothness_, source_.slots(), effort_, job)) return {};
  slot_map_.store(window, grid);
  Energy rise = with_ring(ring_energy(window, source_, smoothness_, grid));
  rise -= before;
  return rise;
}

// Energy of the pixels of a core and of the edges that lead down and to the right from them.
Energy WindowReoptimisation::core_energy(const Cell& cell, const Window& outer, const LabelGrid& grid) const {
  const int left = (cell.column.core_begin - outer.x + 2 * source_.width()) % source_.width();
  const int top = cell.row.core_begin - outer.y;
  Energy energy;
  for (int x = left; x < left + cell.column.core_size; ++x)
    for (int y = top; y < top + cell.row.core_size; ++y)
      energy += energy_of_pixel(grid, smoothness_, x * grid.height + y);
  return energy;
}

}  // namespace ldp::solve
