#include "core/view/raster/occlusion.h"

#include <algorithm>
#include <cmath>

#include "core/view/raster/raster.h"

namespace ldp::view {
namespace {

float smaller(float a, float b) { return a < b ? a : b; }

}  // namespace

Occlusion::Occlusion(const StripTarget& target)
    : x0_(target.x0),
      width_(target.width),
      height_(target.height),
      across_((target.width + kBlockPx - 1) / kBlockPx),
      farthest_(static_cast<size_t>(across_) * static_cast<size_t>((height_ + kBlockPx - 1) / kBlockPx), INFINITY) {
  for (int y = 0; y < height_; ++y) {
    const Fragment* row = &target.opaque[target.pixel(x0_, y)];
    float* blocks = &farthest_[static_cast<size_t>(y / kBlockPx) * static_cast<size_t>(across_)];
    const int whole = width_ / kBlockPx * kBlockPx;
    static_assert(kBlockPx == 4);
    for (int x = 0; x < whole; x += kBlockPx) {
      const float left = smaller(row[x].inverse_z, row[x + 1].inverse_z);
      const float right = smaller(row[x + 2].inverse_z, row[x + 3].inverse_z);
      float& block = blocks[x / kBlockPx];
      block = smaller(block, smaller(left, right));
    }
    for (int x = whole; x < width_; ++x) blocks[across_ - 1] = smaller(blocks[across_ - 1], row[x].inverse_z);
  }
}

uint32_t Occlusion::visible_cells(const CellBounds& bounds) const {
  const auto pixel = [](float position, int last) {
    return static_cast<int>(std::clamp(position, -1.0F, static_cast<float>(last + 1)));
  };
  uint32_t visible = 0;
  for (int i = 0; i < kCells; ++i) {
    const auto left = static_cast<float>(x0_);
    if (bounds.x1[i] < left || bounds.x0[i] > left + static_cast<float>(width_ - 1)) continue;
    if (bounds.y1[i] < 0 || bounds.y0[i] > static_cast<float>(height_ - 1)) continue;
    const int x0 = std::max(0, pixel(bounds.x0[i] - left, width_ - 1));
    const int x1 = std::min(width_ - 1, pixel(bounds.x1[i] - left, width_ - 1));
    const int y0 = std::max(0, pixel(bounds.y0[i], height_ - 1));
    const int y1 = std::min(height_ - 1, pixel(bounds.y1[i], height_ - 1));
    if (!hides(x0, x1, y0, y1, bounds.nearest[i])) visible |= 1U << i;
  }
  return visible;
}

bool Occlusion::hides(int x0, int x1, int y0, int y1, float nearest) const {
  for (int y = y0 / kBlockPx; y <= y1 / kBlockPx; ++y) {
    const float* row = &farthest_[static_cast<size_t>(y) * static_cast<size_t>(across_)];
    for (int x = x0 / kBlockPx; x <= x1 / kBlockPx; ++x)
      if (row[x] < nearest) return false;
  }
  return true;
}

}  // namespace ldp::view
