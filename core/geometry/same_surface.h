// Whether neighbouring samples of a depth map belong to one surface: every stage's one rule, each with its own bounds.
#pragma once

#include <algorithm>

namespace ldp {

// Inverse depth of neighbours, in steps of disparity or as it is. On one surface it differs by at most
//   rounding + share (infinity + the larger one) + slack.
template <typename T>
struct SurfaceTolerance {
  T slack = 0;     // what a slanted surface may change from pixel to pixel, in parallax
  T share = 0;     // and as a share of its inverse depth: a surface seen at a grazing angle
  T infinity = 0;  // what makes values inverse depths when added: 0 where they are

  // `rounding`: what the values' codes leave unknown.
  bool same_surface(T a, T b, T rounding = 0) const {
    const T apart = a > b ? a - b : b - a;
    return apart <= rounding + share * (infinity + std::max(a, b)) + slack;
  }
};

}  // namespace ldp
