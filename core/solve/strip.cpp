#include "strip.h"

#include <algorithm>

namespace ldp {

namespace {

constexpr int kPieceColumns = 64;

}  // namespace

void Strip::plan(int begin, int width) {
  next_begin_ = begin;
  next_width_ = width;
  kept_from_ = source_.wraps() ? (begin - begin_ + source_.width()) % source_.width() : begin - begin_;
  kept_ = kept_from_ >= 0 ? std::clamp(terms_.width - kept_from_, 0, width) : 0;
  pieces_.resize(static_cast<size_t>((width - kept_ + kPieceColumns - 1) / kPieceColumns));
}

void Strip::load_piece(int index) {
  const int first = kept_ + index * kPieceColumns, count = std::min(kPieceColumns, next_width_ - first);
  const int x = (next_begin_ + first) % source_.width();
  source_.load({x, 0, count, source_.height()}, pieces_[static_cast<size_t>(index)]);
}

void Strip::move() {
  if (kept_ > 0) terms_.take_columns(terms_, kept_from_, kept_, 0);  // in place, towards the front
  terms_.resize(next_width_, source_.height(), source_.has_positions());
  int first = kept_;
  for (const PixelTerms& piece : pieces_) {
    terms_.take_columns(piece, 0, piece.width, first);
    first += piece.width;
  }
  begin_ = next_begin_;
}

size_t Strip::bytes() const {
  size_t sum = terms_.bytes();
  for (const PixelTerms& piece : pieces_) sum += piece.bytes();
  return sum;
}

void Strip::copy(const Window& part, LabelGrid& grid) const {
  grid.resize(part.width, part.height, source_.has_positions());
  for (int x = 0; x < part.width; ++x) {
    const auto from = static_cast<ptrdiff_t>((part.x + x) * terms_.height + part.y);
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

bool Strip::any_solved(const Window& part) const {
  for (int x = part.x; x < part.x + part.width; ++x) {
    const uint8_t* column = terms_.solved.data() + static_cast<ptrdiff_t>(x) * terms_.height + part.y;
    if (std::any_of(column, column + part.height, [](uint8_t solved) { return solved != 0; })) return true;
  }
  return false;
}

Energy Strip::energy(const Window& part, const uint8_t* labels) const {
  Energy energy;
  for (int x = 0; x < part.width; ++x)
    for (int y = 0; y < part.height; ++y) {
      const int p = (part.x + x) * terms_.height + part.y + y;
      if (!terms_.solved[static_cast<size_t>(p)]) continue;
      const uint8_t* label = labels + x * part.height + y;
      energy.data += terms_.costs(p)[*label] + (terms_.floor.empty() ? 0 : terms_.floor[static_cast<size_t>(p)]);
      const auto add_edge = [&](int q, int other, bool down) {
        if (!terms_.solved[static_cast<size_t>(q)]) return;
        const int factor = source_.edge_factor(column(part.x + x), part.y + y, down);
        if (factor != 0) energy.smoothness += terms_.pair(smoothness_, factor, p, *label, q, other);
      };
      if (y + 1 < part.height) add_edge(p + 1, label[1], true);
      if (x + 1 < part.width) add_edge(p + terms_.height, label[part.height], false);
    }
  return energy;
}

}  // namespace ldp
