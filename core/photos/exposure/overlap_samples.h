// What overlapping photographs show of the same things, as colours of small blocks.
#pragma once

#include <array>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"

namespace ldp {

// Means of square blocks of a photo, and how far a block's pixels can be trusted (no clipped pixel).
struct Thumbnail {
  int block_px = 0;
  Plane<std::array<float, 3>> mean;
  Plane<uint8_t> usable;
};

Thumbnail make_thumbnail(const RgbImage& photo);

namespace exposure {

// One thing in two photographs: levels of R, G and B.
struct PairedColours {
  std::array<double, 3> a{}, b{};
};

struct Overlap {
  int a = 0, b = 0;  // photographs, a < b
  std::vector<PairedColours> colours;
};

// Of all photographs that overlap. They are compared by the points that they share. Two that look in the same direction
// from afar see different things in it: directions are asked only of photographs that no chain of points joins.
std::vector<Overlap> overlaps(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
                              const std::vector<ScenePoint>& points);

}  // namespace exposure
}  // namespace ldp
