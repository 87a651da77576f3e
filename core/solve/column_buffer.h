// The columns of a problem that are being worked on, at full height. A problem is walked through from left to right,
// place by place; what a place shares with the one before it is kept, so that terms are computed once, and what only
// earlier places needed is overwritten, so that no whole volume ever exists.
//
// Columns are counted along the walk, from the first of the first place on: on a ring a column may be met twice.
#pragma once

#include <cstddef>
#include <vector>

#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/smoothness.h"

namespace ldp::solve {

class ColumnBuffer {
 public:
  static constexpr int kHeld = 3;  // pieces that exist at a time

  ColumnBuffer(const GridSource& source, const Smoothness& smoothness) : source_(source), smoothness_(smoothness) {}

  // Plans a walk whose place i spans the x and width of places[i]; neighbouring places overlap or touch.
  void plan(const std::vector<Window>& places);
  int begin(int place) const { return begins_[static_cast<size_t>(place)]; }
  int end(int place) const { return ends_[static_cast<size_t>(place)]; }

  // The columns that a place holds and no place before it are its piece. From several threads, rows of any pieces are
  // loaded once nothing needs the piece kHeld before; a place needs its own piece and the one before it.
  int piece_begin(int place) const { return place == 0 ? 0 : end(place - 1); }
  void load_rows(int place, int y, int rows);

  // Of the source.
  int column(int x) const { return (first_column_ + x) % source_.width(); }
  const PixelTerms& terms() const { return terms_; }
  // Where the terms of a column begin.
  int pixel(int x) const { return column_of_terms_[static_cast<size_t>(x)] * terms_.height; }
  size_t bytes() const { return terms_.bytes() + column_of_terms_.capacity() * sizeof(int); }

  // Terms and edges of a part of the buffer.
  void copy(const Window& part, LabelGrid& grid) const;

  // Whether a part holds pixels of the problem.
  bool any_solved(const Window& part) const;

  // Energy of a column's pixels, floors included, and of the edges between them.
  Energy column_energy(int x, const std::vector<uint8_t>& labels) const;
  // The pair terms of the edges between columns x and x + 1.
  int64_t seam_energy(int x, const std::vector<uint8_t>& labels, const std::vector<uint8_t>& next) const;

 private:
  const GridSource& source_;
  const Smoothness& smoothness_;
  int first_column_ = 0;
  std::vector<int> begins_, ends_;    // of each place
  std::vector<int> column_of_terms_;  // of each column
  PixelTerms terms_;
};

}  // namespace ldp::solve
