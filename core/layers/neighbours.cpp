#include "core/layers/neighbours.h"

#include <algorithm>

#include "core/layers/layers.h"

namespace ldp::layers {

int neighbour_column(const PanoramaGrid& grid, int x) {
  if (x >= 0 && x < grid.width) return x;
  return grid.wraps ? (x + grid.width) % grid.width : -1;
}

double parallax_steps(const PanoramaGrid& grid, double px) {
  const double range = grid.w_near - grid.w_far;
  if (range <= 0) return kLabelSteps;
  const double steps = px * grid.v_pitch / (std::max(grid.arc.radius, 1e-9) * range) * kDisparitySteps;
  return std::min(steps, 1.0 * kDisparitySteps);
}

}  // namespace ldp::layers
