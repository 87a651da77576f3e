// Frames turned upright: rotated by a homography so that the image plane is parallel to the arc's axis n. A
// vertical line of panorama voxels (fixed theta and depth) then projects to ONE column, with the row affine in v.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/upright_camera.h"
#include "core/photos/exposure_gain.h"

namespace ldp {

// Samples stored column by column: sample (x, y) at columns.at(y, x), i.e. a plane of `height` wide and `width` high,
// so that one image column is contiguous; grey in `columns`, red minus green plus 128 in `tint`. valid_begin/valid_end
// give, per column, the half-open range of rows that lie inside the photograph.
struct UprightFrame {
  UprightCamera camera;
  GreyImage columns, tint;
  std::vector<int16_t> valid_begin, valid_end;
  Gain gain = {1, 1, 1};  // of this photograph to match the others
};

}  // namespace ldp
