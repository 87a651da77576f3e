// Which cells of a tile cannot show in a strip of a view, because they lie outside it or something nearer is drawn.
#pragma once

#include <cstdint>
#include <vector>

#include "core/view/raster/view_frustum.h"

namespace ldp::view {

struct StripTarget;

// The farthest of what a strip shows so far, in blocks of pixels. What is drawn later only hides more.
class Occlusion {
 public:
  explicit Occlusion(const StripTarget& target);

  // Bit i: cell i may show.
  uint32_t visible_cells(const CellBounds& bounds) const;

 private:
  bool hides(int x0, int x1, int y0, int y1, float nearest) const;

  static constexpr int kBlockPx = 4;
  int x0_, width_, height_;  // of the strip
  int across_ = 0;
  std::vector<float> farthest_;
};

}  // namespace ldp::view
