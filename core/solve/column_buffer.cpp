#include "core/solve/column_buffer.h"

#include <algorithm>
#include <array>

namespace ldp::solve {

void ColumnBuffer::plan(const std::vector<Window>& places) {
  first_column_ = places[0].x;
  begins_.clear();
  ends_.clear();
  std::array<int, kHeld> width{};  // of the widest piece in each part of the terms
  for (size_t i = 0, begin = 0; i < places.size(); ++i) {
    if (i > 0) begin += static_cast<size_t>((places[i].x - places[i - 1].x + source_.width()) % source_.width());
    begins_.push_back(static_cast<int>(begin));
    ends_.push_back(static_cast<int>(begin) + places[i].width);
    int& widest = width[i % kHeld];
    widest = std::max(widest, end(static_cast<int>(i)) - piece_begin(static_cast<int>(i)));
  }
  std::array<int, kHeld> first{};
  for (size_t k = 1; k < kHeld; ++k) first[k] = first[k - 1] + width[k - 1];
  terms_.resize(first.back() + width.back(), source_.height(), source_.has_positions());
  column_of_terms_.clear();
  for (size_t i = 0; i < places.size(); ++i)
    for (int x = piece_begin(static_cast<int>(i)); x < ends_[i]; ++x)
      column_of_terms_.push_back(first[i % kHeld] + x - piece_begin(static_cast<int>(i)));
}

void ColumnBuffer::load_rows(int place, int y, int rows) {
  const int x = piece_begin(place);
  if (x < end(place)) source_.load({column(x), y, end(place) - x, rows}, terms_, pixel(x) + y);
}

void ColumnBuffer::copy(const Window& part, LabelGrid& grid) const {
  grid.resize(part.width, part.height, source_.has_positions());
  for (int x = 0; x < part.width; ++x) {
    const auto from = static_cast<ptrdiff_t>(pixel(part.x + x) + part.y);
    const auto to = static_cast<ptrdiff_t>(x * part.height);
    const auto take = [&](const auto& source, auto& target, int each) {
      std::copy_n(source.begin() + from * each, part.height * each, target.begin() + to * each);
    };
    take(terms_.cost, grid.cost, kSlots);
    take(terms_.grey, grid.grey, kSlots);
    take(terms_.solved, grid.solved, 1);
    if (source_.has_positions()) take(terms_.position, grid.position, kSlots);
  }
  grid.find_grey_ranges();
  set_edges(source_, {column(part.x), part.y, part.width, part.height}, grid);
}

bool ColumnBuffer::any_solved(const Window& part) const {
  for (int x = part.x; x < part.x + part.width; ++x) {
    const uint8_t* column = terms_.solved.data() + pixel(x) + part.y;
    if (std::any_of(column, column + part.height, [](uint8_t solved) { return solved != 0; })) return true;
  }
  return false;
}

Energy ColumnBuffer::column_energy(int x, const std::vector<uint8_t>& labels) const {
  Energy energy;
  for (size_t y = 0; y < labels.size(); ++y) {
    const int p = pixel(x) + static_cast<int>(y);
    if (!terms_.solved[static_cast<size_t>(p)]) continue;
    energy.data += terms_.costs(p)[labels[y]] + (terms_.floor.empty() ? 0 : terms_.floor[static_cast<size_t>(p)]);
    if (y == 0 || !terms_.solved[static_cast<size_t>(p - 1)]) continue;
    const int factor = source_.edge_factor(column(x), static_cast<int>(y) - 1, true);
    if (factor != 0) energy.smoothness += terms_.pair(smoothness_, factor, p - 1, labels[y - 1], p, labels[y]);
  }
  return energy;
}

int64_t ColumnBuffer::seam_energy(int x, const std::vector<uint8_t>& labels, const std::vector<uint8_t>& next) const {
  int64_t energy = 0;
  for (size_t y = 0; y < labels.size(); ++y) {
    const int p = pixel(x) + static_cast<int>(y), q = pixel(x + 1) + static_cast<int>(y);
    if (!terms_.solved[static_cast<size_t>(p)] || !terms_.solved[static_cast<size_t>(q)]) continue;
    const int factor = source_.edge_factor(column(x), static_cast<int>(y), false);
    if (factor != 0) energy += terms_.pair(smoothness_, factor, p, labels[y], q, next[y]);
  }
  return energy;
}

}  // namespace ldp::solve
