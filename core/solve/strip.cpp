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

Energy Strip::column_energy(int x, const std::vector<uint8_t>& labels) const {
  Energy energy;
  for (size_t y = 0; y < labels.size(); ++y) {
    const int p = x * terms_.height + static_cast<int>(y);
    if (!terms_.solved[static_cast<size_t>(p)]) continue;
    energy.data += terms_.costs(p)[labels[y]] + (terms_.floor.empty() ? 0 : terms_.floor[static_cast<size_t>(p)]);
    if (y == 0 || !terms_.solved[static_cast<size_t>(p - 1)]) continue;
    const int factor = source_.edge_factor(column(x), static_cast<int>(y) - 1, true);
    if (factor != 0) energy.smoothness += terms_.pair(smoothness_, factor, p - 1, labels[y - 1], p, labels[y]);
  }
  return energy;
}

int64_t Strip::seam_energy(int x, const std::vector<uint8_t>& labels, const std::vector<uint8_t>& next) const {
  int64_t energy = 0;
  for (size_t y = 0; y < labels.size(); ++y) {
    const int p = x * terms_.height + static_cast<int>(y), q = p + terms_.height;
    if (!terms_.solved[static_cast<size_t>(p)] || !terms_.solved[static_cast<size_t>(q)]) continue;
    const int factor = source_.edge_factor(column(x), static_cast<int>(y), false);
    if (factor != 0) energy += terms_.pair(smoothness_, factor, p, labels[y], q, next[y]);
  }
  return energy;
}

void Strip::clear() {
  terms_ = {};
  pieces_.clear();
  pieces_.shrink_to_fit();
}

}  // namespace ldp
