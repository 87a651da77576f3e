// A layer of which little is present: of each column only the rows from its first pixel to its last.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/geometry/disparity.h"
#include "core/view/mesh/mesh.h"

namespace ldp::view {

struct SparsePixel {  // as PreparedLayer has it in planes
  float w = kAbsent;
  Rgba colour = 0;
  uint16_t code = kNoDisparity;
  uint8_t step = 0;
};

class SparseColumns {
 public:
  // Rows [begin, end) of the panorama, which may lie beyond it; none if end <= begin.
  struct Rows {
    int begin = 0, end = 0;
    void include(int row) {
      *this = end <= begin ? Rows{row, row + 1} : Rows{std::min(begin, row), std::max(end, row + 1)};
    }
  };

  SparseColumns() = default;
  explicit SparseColumns(std::vector<Rows> columns) : columns_(std::move(columns)), first_(columns_.size()) {
    size_t pixels = 0;
    for (size_t x = 0; x < columns_.size(); ++x) {
      first_[x] = pixels;
      if (columns_[x].end <= columns_[x].begin) continue;
      pixels += static_cast<size_t>(columns_[x].end - columns_[x].begin);
      all_.include(columns_[x].begin), all_.include(columns_[x].end - 1);
    }
    pixels_.resize(pixels);
  }

  bool empty() const { return pixels_.empty(); }
  int width() const { return static_cast<int>(columns_.size()); }
  Rows rows() const { return all_; }  // of all columns together

  bool contains(int x, int y) const {
    if (x < 0 || x >= width()) return false;
    const Rows& rows = columns_[static_cast<size_t>(x)];
    return y >= rows.begin && y < rows.end;
  }
  SparsePixel at(int x, int y) const { return contains(x, y) ? pixels_[index(x, y)] : SparsePixel{}; }
  SparsePixel& slot(int x, int y) { return pixels_[index(x, y)]; }  // which it contains

  // Whether any of columns [x0, x1) has a pixel in rows [y0, y1), or room for one.
  bool any(int x0, int x1, int y0, int y1) const {
    return std::any_of(columns_.begin() + std::min(x0, width()), columns_.begin() + std::min(x1, width()),
                       [&](const Rows& rows) { return std::max(rows.begin, y0) < std::min(rows.end, y1); });
  }

 private:
  size_t index(int x, int y) const {
    const auto column = static_cast<size_t>(x);
    return first_[column] + static_cast<size_t>(y - columns_[column].begin);
  }

  std::vector<Rows> columns_;
  std::vector<size_t> first_;  // of each column's pixels
  std::vector<SparsePixel> pixels_;
  Rows all_;
};

}  // namespace ldp::view
