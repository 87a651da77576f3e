// The columns of a problem that are being worked on, at full height. Moving on keeps what both places share, so that a
// problem's terms are computed once while it is walked through from left to right, and no whole volume ever exists.
#pragma once

#include <cstddef>
#include <vector>

#include "label_grid.h"
#include "smoothness.h"

namespace ldp {

class Strip {
 public:
  Strip(const GridSource& source, const Smoothness& smoothness) : source_(source), smoothness_(smoothness) {}

  // Announces columns [begin, begin + width), modulo the source's width where it wraps. Pieces of them that the strip
  // does not hold yet are to be loaded, in any order and from several threads, before `move` goes there.
  void plan(int begin, int width);
  int pieces() const { return static_cast<int>(pieces_.size()); }
  void load_piece(int index);
  void move();

  int width() const { return terms_.width; }
  int column(int x) const { return (begin_ + x) % source_.width(); }
  const PixelTerms& terms() const { return terms_; }
  size_t bytes() const;

  // Terms and edges of a part of the strip, x counted from the strip's first column.
  void copy(const Window& part, LabelGrid& grid) const;

  // Whether a part holds pixels of the problem.
  bool any_solved(const Window& part) const;

  // Energy of a column's pixels, floors included, and of the edges between them.
  Energy column_energy(int x, const std::vector<uint8_t>& labels) const;
  // The pair terms of the edges between columns x and x + 1.
  int64_t seam_energy(int x, const std::vector<uint8_t>& labels, const std::vector<uint8_t>& next) const;

  // Lets go of everything.
  void clear();

 private:
  const GridSource& source_;
  const Smoothness& smoothness_;
  int begin_ = 0, next_begin_ = 0, next_width_ = 0;
  int kept_from_ = 0, kept_ = 0;  // columns of the strip that the next place shares
  PixelTerms terms_;
  std::vector<PixelTerms> pieces_;
};

}  // namespace ldp
