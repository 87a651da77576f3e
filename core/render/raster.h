// Draws a mesh's tiles into one vertical strip of a view: opaque surfaces into a z-buffer, soft ones into short lists
// per pixel that are blended front to back afterwards. What a strip shows does not depend on where strips begin and
// end.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh.h"
#include "view_frustum.h"

namespace ldp::render {

constexpr float kNothing = -1;  // inverse z of a pixel that no surface covers; infinity is 0
constexpr int kSoftDepth = 4;   // soft fragments kept per pixel; farther ones are dropped

struct Fragment {
  float inverse_z = kNothing;
  Rgba colour = 0;
};

// Columns [x0, x0 + width) of the image.
struct StripTarget {
  int x0 = 0, width = 0, height = 0;
  std::vector<Fragment> opaque;
  std::vector<uint8_t> soft_count;
  std::vector<Fragment> soft;  // kSoftDepth per pixel, nearest first

  StripTarget(int strip_x0, int strip_width, int strip_height);
};

void draw(const Mesh& mesh, const ViewFrustum& frustum, int layers, StripTarget& target);

// A pixel's layers over each other: colour not multiplied by alpha.
struct Blended {
  Rgba colour = 0;
  float inverse_z = kNothing;  // of the surface at which opacity passes one half
};
Blended blend(const StripTarget& target, size_t pixel);

}  // namespace ldp::render
