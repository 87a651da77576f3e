// A layer as a surface over the panorama's grid that tears where views do (core/view/tears.h), with few triangles: a
// quadtree of cells over pixel centres, each a quad where inverse depth is bilinear to within a tolerance, split where
// not.
//
// Cells of different size meet with cracks below the tolerance, less than a pixel of parallax in the viewing space.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/panorama/panorama.h"

namespace ldp {

constexpr int kSurfaceLargestCell = 32;  // pixels a side
constexpr int kSurfaceTolerance = 12;    // disparity steps at least: 0.3 % of the inverse-depth range
constexpr int kSurfaceSlope = 40;        // a cell changes by no more from pixel to pixel, in disparity steps

struct SurfaceVertex {
  float x_px = 0, y_px = 0;  // place on the grid, continuous (pixel centres at .5)
  float u_px = 0, v_px = 0;  // place of its colour
  float disparity = 0;       // in steps of 1 / kDisparitySteps
};

struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<uint32_t> triangles;  // three indices each, anticlockwise seen from the arc
};

// The quads between pixel columns [begin, end). In a panorama that wraps, the quad behind the last column leads to
// column 0.
struct SurfacePart {
  int begin = 0, end = 0;
  int step = 1;  // pixels a side of the smallest cells: 1, 2, 4 ... kSurfaceLargestCell
  int tolerance = kSurfaceTolerance;
};

Surface make_surface(const LayeredPanorama& panorama, size_t layer, const SurfacePart& part, const Job& job = {});

// The layer's colour with absent pixels continued from the nearest present one of their row, so that filtering at
// silhouettes takes in nothing foreign.
RgbImage spread_colour(const Layer& layer);

}  // namespace ldp
