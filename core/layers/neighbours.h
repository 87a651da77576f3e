// What the files of this stage share: places in the panorama, and parallax.
#pragma once

#include <cstdint>

#include "core/geometry/geometry.h"

namespace ldp::layers {

constexpr uint16_t kUncovered = 0;  // of a visibility map

// -1 = outside the panorama.
int neighbour_column(const PanoramaGrid& grid, int x);

// Disparity steps that shift a voxel by so many pixels when the eye moves by one arc radius; at most all there are,
// where not even those do.
double parallax_steps(const PanoramaGrid& grid, double px);

}  // namespace ldp::layers
