// A picture at half its size, for coarse looks.
#pragma once

#include "core/base/plane.h"

namespace ldp {

// Each pixel is the mean of four; an odd last row or column is left out.
inline GreyImage halved(const GreyImage& image) {
  GreyImage half(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height; ++y) {
    const uint8_t *p = image.row(2 * y), *q = image.row(2 * y + 1);
    for (int x = 0; x < half.width; ++x, p += 2, q += 2)
      half.at(x, y) = static_cast<uint8_t>((p[0] + p[1] + q[0] + q[1] + 2) / 4);
  }
  return half;
}

}  // namespace ldp
