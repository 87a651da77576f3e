// A layer of a panorama made ready for its mesh, and which of its pixels belong together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/plane.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/geometry/same_surface.h"
#include "core/view/mesh/mesh.h"
#include "core/view/view_tuning.h"

namespace ldp::view {

struct PreparedLayer {
  Plane<float> w;  // inverse depth; kAbsent where the layer is not present
  Plane<Rgba> colour;
  // For telling surfaces apart: disparity exactly as coded (kNoDisparity where absent), and between neighbouring codes.
  Plane<uint16_t> code;
  Plane<uint8_t> step;
};

// Inverse depths of codes.
class CodedDepths {
 public:
  explicit CodedDepths(const PanoramaGrid& grid);
  float w(uint16_t code) const { return code == kNoDisparity ? kAbsent : w_[code]; }
  float step(uint8_t disparities) const { return steps_[disparities]; }

 private:
  std::array<float, kDisparitySteps + 1> w_{};
  std::array<float, 256> steps_{};
};

// Whether two pixels whose codes stand for inverse depths a and b are of one surface; neither is when it is absent.
// `parallax`: what a very slanted surface may change from pixel to pixel, beside a share of its inverse depth.
inline bool connected(float a, float a_step, float b, float b_step, float parallax) {
  if (a < 0 || b < 0) return false;
  return SurfaceTolerance<float>{parallax, kSlant}.same_surface(a, b, 0.51F * (a_step + b_step));
}

}  // namespace ldp::view
