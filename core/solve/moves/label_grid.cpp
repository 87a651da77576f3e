#include "core/solve/moves/label_grid.h"

#include <algorithm>

namespace ldp::solve {

namespace {

// Without room to grow further, which a window or strip, once of full size, never needs.
template <typename T>
void resize_exactly(std::vector<T>& values, size_t size) {
  values.reserve(size);
  values.resize(size);
}

}  // namespace

void PixelTerms::resize(int new_width, int new_height, bool with_positions) {
  width = new_width;
  height = new_height;
  const auto n = static_cast<size_t>(width) * static_cast<size_t>(height);
  resize_exactly(cost, n * kSlots);
  resize_exactly(floor, with_positions ? n : 0);
  resize_exactly(grey, n * kSlots);
  resize_exactly(position, with_positions ? n * kSlots : 0);
  resize_exactly(solved, n);
}

size_t PixelTerms::bytes() const {
  return (cost.capacity() + floor.capacity()) * sizeof(uint16_t) + grey.capacity() + position.capacity() +
         solved.capacity();
}

void LabelGrid::resize(int new_width, int new_height, bool with_positions) {
  PixelTerms::resize(new_width, new_height, with_positions);
  const auto n = static_cast<size_t>(size());
  resize_exactly(grey_range, n * 2);
  message.assign(n * kSlots * 4, 0);
  down.assign(n, 0);
  right.assign(n, 0);
  fresh.assign(n, 3);
  label.assign(n, 0);
}

size_t LabelGrid::bytes() const {
  return PixelTerms::bytes() + grey_range.capacity() + message.capacity() + down.capacity() + right.capacity() +
         label.capacity() + fresh.capacity();
}

void LabelGrid::find_grey_ranges() { message_kernels().grey_ranges(grey.data(), size(), grey_range.data()); }

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
  grid.fresh = fresh.data();
  grid.truncation = smoothness.truncation();
  grid.coarse = smoothness.coarse();
  grid.fine = smoothness.fine();
  grid.weight = smoothness.weights();
  return grid;
}

void coarsen(const LabelGrid& fine, LabelGrid& coarse) {
  constexpr int kCeiling = 20000;  // keeps sums of costs and messages within 16 bits
  coarse.resize((fine.width + 1) / 2, (fine.height + 1) / 2, !fine.position.empty());
  const auto at = [](const LabelGrid& grid, int x, int y) {
    return static_cast<size_t>(std::min(x, grid.width - 1)) * static_cast<size_t>(grid.height) +
           static_cast<size_t>(std::min(y, grid.height - 1));
  };
  for (int x = 0; x < coarse.width; ++x)
    for (int y = 0; y < coarse.height; ++y) {
      const size_t p = at(coarse, x, y);
      const size_t block[4] = {at(fine, 2 * x, 2 * y), at(fine, 2 * x, 2 * y + 1), at(fine, 2 * x + 1, 2 * y),
                               at(fine, 2 * x + 1, 2 * y + 1)};
      for (size_t slot = 0; slot < kSlots; ++slot) {
        int sum = 0;
        for (const size_t q : block) sum += fine.cost[q * kSlots + slot];
        coarse.cost[p * kSlots + slot] = static_cast<uint16_t>(std::min(sum / 2, kCeiling));
      }
      std::copy_n(fine.grey.begin() + static_cast<ptrdiff_t>(block[0] * kSlots), kSlots,
                  coarse.grey.begin() + static_cast<ptrdiff_t>(p * kSlots));
      if (!fine.position.empty())
        std::copy_n(fine.position.begin() + static_cast<ptrdiff_t>(block[0] * kSlots), kSlots,
                    coarse.position.begin() + static_cast<ptrdiff_t>(p * kSlots));
      std::copy_n(fine.grey_range.begin() + static_cast<ptrdiff_t>(block[0] * 2), 2,
                  coarse.grey_range.begin() + static_cast<ptrdiff_t>(p * 2));
      if (y + 1 < coarse.height) coarse.down[p] = std::max(fine.down[block[1]], fine.down[block[3]]);
      if (x + 1 < coarse.width) coarse.right[p] = std::max(fine.right[block[2]], fine.right[block[3]]);
    }
}

void spread_messages(const LabelGrid& coarse, LabelGrid& fine) {
  for (int x = 0; x < fine.width; ++x)
    for (int y = 0; y < fine.height; ++y) {
      const int p = x * fine.height + y, block = x / 2 * coarse.height + y / 2;
      for (int direction = 0; direction < 4; ++direction)
        if (fine.factor(p, direction) != 0)
          std::copy_n(coarse.messages(block, direction), kSlots,
                      fine.message.begin() + (static_cast<ptrdiff_t>(p) * 4 + direction) * kSlots);
    }
}

static Energy energy_of_pixel(const LabelGrid& grid, const Smoothness& smoothness, int p) {
  const int a = grid.label[static_cast<size_t>(p)];
  Energy energy;
  energy.data = grid.costs(p)[a];
  for (const int direction : {kDown, kRight}) {
    const int factor = grid.factor(p, direction);
    if (factor == 0) continue;
    const int q = p + grid.stride(direction);
    energy.smoothness += grid.pair(smoothness, factor, p, a, q, grid.label[static_cast<size_t>(q)]);
  }
  return energy;
}

Energy energy_of(const LabelGrid& grid, const Smoothness& smoothness) {
  Energy energy;
  for (int p = 0; p < grid.size(); ++p) energy += energy_of_pixel(grid, smoothness, p);
  return energy;
}

void set_edges(const GridSource& source, const Window& window, LabelGrid& grid) {
  for (int x = 0; x < window.width; ++x) {
    const int column = (window.x + x) % source.width();
    for (int y = 0; y < window.height; ++y) {
      const auto p = static_cast<size_t>(x * window.height + y);
      const auto factor = [&](size_t other, bool down) {
        if (!grid.solved[p] || !grid.solved[other]) return uint8_t{0};
        return static_cast<uint8_t>(source.edge_factor(column, window.y + y, down));
      };
      grid.down[p] = y + 1 < window.height ? factor(p + 1, true) : uint8_t{0};
      grid.right[p] = x + 1 < window.width ? factor(p + static_cast<size_t>(window.height), false) : uint8_t{0};
    }
  }
}

}  // namespace ldp::solve
