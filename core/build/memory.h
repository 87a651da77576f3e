// How much memory the stages after the poses hold at most: what `--memory` compares.
#pragma once

#include <cstddef>

#include "geometry.h"

namespace ldp {

// Bytes of the whole process, from the panorama's grid, the pixels of one photo and of all upright frames together, and
// the layers.
size_t expected_peak_bytes(const PanoramaGrid& grid, size_t photo_px, size_t upright_px, int layers);

}  // namespace ldp
