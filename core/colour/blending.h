// Blending: what photographs agree on where several of them see a surface.
//
// Where a depth is a little wrong, something has moved or a sample is mixed with an edge, the photograph that a pixel
// is taken from differs from the others; everywhere its noise does. Photographs also differ in brightness over wide
// areas (vignetting, tone mapping, haze), and each sees a part of the panorama only: mixed as they are, their borders
// would show. So the others are first given the brightness of the pixel's own photograph.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/colour/colour.h"
#include "core/colour/photo_sampler.h"
#include "core/geometry/geometry.h"

namespace ldp::colour {

// The photographs that are asked what they show of a pixel, beside its own: those taken just before and after it (of a
// closed sweep, too, the first has none before it).
constexpr int kViewsAside = 3, kNeighbourViews = 2 * kViewsAside;

// Which of them is the one taken `offset` later (-kViewsAside .. kViewsAside, not 0).
constexpr int neighbour_bit(int offset) { return offset < 0 ? offset + kViewsAside : offset + kViewsAside - 1; }

// Per channel the mean of all but a quarter at either end, rounded: the median of three, the mean of the middle three
// of five or seven. Of one or two samples, the first. At least one, at most 1 + kNeighbourViews.
Colour consensus(std::span<const Colour> samples);

// By how much the photographs beside one of them (by neighbour_bit) are brighter than it, where both see one surface:
// the median of a cell, bilinear between cells.
class BrightnessDifferences {
 public:
  explicit BrightnessDifferences(const PanoramaGrid& grid);
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  // Where a cell begins, and the one before it ends.
  int begin_x(int column) const { return column * width_ / columns_; }
  int begin_y(int row) const { return row * height_ / rows_; }
  void clear();

  // Of a cell. Of fewer than kBrightnessLeastSamples nothing is known.
  void set(int column, int row, int neighbour, std::vector<Colour>& samples);
  // Between the cells that know it; nothing where none does.
  std::optional<Colour> at(int x, int y, int neighbour) const;

 private:
  size_t place(int column, int row, int neighbour) const;

  int width_, height_;
  bool wraps_;
  int columns_, rows_;
  std::vector<std::optional<Colour>> cells_;
};

}  // namespace ldp::colour
