// A layer of a panorama made ready for its mesh, and which of its pixels belong together.
#pragma once

#include "core/base/plane.h"
#include "core/view/mesh/mesh.h"

namespace ldp::render {

// One column wider than the panorama if that wraps: the last one is the first one again.
struct PreparedLayer {
  Plane<float> w;  // inverse depth; kAbsent where the layer is not present
  Plane<Rgba> colour;
  Plane<float> code_w;  // inverse depth exactly as coded, for telling surfaces apart
  Plane<float> step;    // difference of inverse depth between neighbouring codes
};

// Whether two pixels whose codes stand for inverse depths a and b are of one surface; neither is when it is absent.
// `parallax`: what a very slanted surface may change from pixel to pixel, beside a share of its inverse depth.
bool connected(float a, float a_step, float b, float b_step, float parallax);

}  // namespace ldp::render
