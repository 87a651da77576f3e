#include "label_grid.h"

#include <algorithm>

namespace ldp {

void LabelGrid::resize(int new_width, int new_height, bool with_positions) {
  width = new_width;
  height = new_height;
  const auto n = static_cast<size_t>(width) * static_cast<size_t>(height);
  cost.resize(n * kSlots);
  grey.resize(n * kSlots);
  position.resize(with_positions ? n * kSlots : 0);
  grey_range.resize(n * 2);
  message.assign(n * kSlots * 4, 0);
  down.assign(n, 0);
  right.assign(n, 0);
  label.assign(n, 0);
}

size_t LabelGrid::bytes() const {
  return cost.capacity() * sizeof(uint16_t) + grey.capacity() + grey_range.capacity() + position.capacity() +
         message.capacity() + down.capacity() + right.capacity() + label.capacity();
}

void LabelGrid::find_grey_ranges() {
  for (int p = 0; p < size(); ++p) {
    const auto [least, largest] = std::minmax_element(greys(p), greys(p) + kSlots);
    grey_range[static_cast<size_t>(p) * 2] = *least;
    grey_range[static_cast<size_t>(p) * 2 + 1] = *largest;
  }
}

KernelGrid LabelGrid::kernel_grid(const Smoothness& smoothness) {
  KernelGrid grid;
  grid.width = width;
  grid.height = height;
  grid.cost = cost.data();
  grid.grey = grey.data();
  grid.grey_range = grey_range.data();
  grid.position = position.empty() ? nullptr : position.data();
  grid.down = down.data();
  grid.right = right.data();
  grid.message = message.data();
  grid.label = label.data();
  grid.truncation = smoothness.truncation();
  grid.coarse = smoothness.coarse();
  grid.fine = smoothness.fine();
  grid.weight = smoothness.weights();
  return grid;
}

int LabelGrid::factor(int p, int direction) const {
  switch (direction) {
    case kDown:
      return down[static_cast<size_t>(p)];
    case kRight:
      return right[static_cast<size_t>(p)];
    case kUp:
      return p >= 1 ? down[static_cast<size_t>(p - 1)] : 0;
    default:
      return p >= height ? right[static_cast<size_t>(p - height)] : 0;
  }
}

Energy energy_of(const LabelGrid& grid, const Smoothness& smoothness) {
  Energy energy;
  for (int p = 0; p < grid.size(); ++p) {
    const int a = grid.label[static_cast<size_t>(p)];
    energy.data += grid.costs(p)[a];
    for (const int direction : {kDown, kRight}) {
      const int factor = grid.factor(p, direction);
      if (factor == 0) continue;
      const int q = p + grid.stride(direction);
      energy.smoothness += grid.pair(smoothness, factor, p, a, q, grid.label[static_cast<size_t>(q)]);
    }
  }
  return energy;
}

}  // namespace ldp
