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

// Between four samples of a picture stored so; in 1/16 px from the middle of sample (0, 0), which is at (0, 0).
inline uint8_t interpolated(const GreyImage& columns, int x16, int y16) {
  const int right = x16 & 15, below = y16 & 15;
  const uint8_t *a = columns.row(x16 >> 4) + (y16 >> 4), *b = columns.row((x16 >> 4) + 1) + (y16 >> 4);
  const int left_side = a[0] * (16 - below) + a[1] * below, right_side = b[0] * (16 - below) + b[1] * below;
  return static_cast<uint8_t>((left_side * (16 - right) + right_side * right + 128) >> 8);
}

}  // namespace ldp
