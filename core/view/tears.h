// Where surfaces tear in views, for the renderer's mesh and for what else draws a panorama's layers.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "core/base/plane.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/geometry/same_surface.h"
#include "core/view/view_tuning.h"

namespace ldp::view {

// What neighbouring pixels of one surface may differ by, besides their share (kSlant) [1 / unit of depth].
inline double surface_slack(const PanoramaGrid& grid, double parallax_px = kParallaxPx) {
  const double radius = grid.arc.radius > 0 ? grid.arc.radius : 1;
  return parallax_px * grid.v_pitch / radius;
}

inline bool look_alike(Rgb a, Rgb b) {
  const auto near = [](int one, int other) { return std::abs(one - other) <= kAlikeLevels; };
  return near(a.r, b.r) && near(a.g, b.g) && near(a.b, b.b);
}

// The whole rule in steps of disparity (1 / kDisparitySteps of the grid's range of inverse depth).
inline SurfaceTolerance<double> joined_in_views(const PanoramaGrid& grid, double parallax_px = kParallaxPx) {
  const double step = std::max(1e-9, grid.w_near - grid.w_far) / kDisparitySteps;
  return {surface_slack(grid, parallax_px) / step, kSlant, grid.w_far / step};
}

}  // namespace ldp::view
