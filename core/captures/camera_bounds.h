// What the numbers of a camera may be, whatever file they come from: beyond, they are a slip, or damage.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/geometry/geometry.h"

namespace ldp {

constexpr double kFarthest = 1e9;    // units of the capture, of a camera from the origin along each axis
constexpr double kMostSides = 4096;  // longer sides of the picture, of focal lengths and centres
constexpr double kMostDistortion = 1e6;

inline bool is_near_enough(const Eigen::Vector3d& centre) { return centre.cwiseAbs().maxCoeff() <= kFarthest; }

inline bool has_usual_lengths(const Intrinsics& k) {
  const double most = kMostSides * std::max(k.width, k.height);
  return std::abs(k.fx) <= most && std::abs(k.fy) <= most && std::abs(k.cx) <= most && std::abs(k.cy) <= most;
}

inline bool has_usual_distortion(const Intrinsics& k) {
  return std::abs(k.k1) <= kMostDistortion && std::abs(k.k2) <= kMostDistortion && std::abs(k.p1) <= kMostDistortion &&
         std::abs(k.p2) <= kMostDistortion;
}

}  // namespace ldp
