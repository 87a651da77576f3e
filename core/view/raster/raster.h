// Draws a mesh's tiles into one vertical strip of a view: opaque surfaces into a z-buffer, soft ones into a list per
// pixel that is blended front to back afterwards. What a strip shows does not depend on where strips begin and end.
#pragma once

#include <cstdint>
#include <vector>

#include "core/view/mesh/mesh.h"
#include "core/view/raster/raster_kernels.h"
#include "core/view/raster/view_frustum.h"

namespace ldp::view {

struct SoftFragment {
  Fragment fragment;
  int32_t next = -1;  // of the same pixel, in no order
};

// Columns [x0, x0 + width) of the image.
struct StripTarget {
  int x0 = 0, width = 0, height = 0;
  std::vector<Fragment> opaque;
  std::vector<int32_t> first_soft;  // index into `soft`, -1 = none
  std::vector<SoftFragment> soft;

  void clear(int strip_x0, int strip_width, int strip_height);
  size_t pixel(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x - x0);
  }
};

void draw(const std::vector<const MeshTile*>& tiles, const ViewFrustum& frustum, StripTarget& target);

// A pixel's surfaces over each other: colour not multiplied by alpha, inverse z of the surface at which opacity passes
// one half.
Fragment blend(const StripTarget& target, size_t pixel);

}  // namespace ldp::view
