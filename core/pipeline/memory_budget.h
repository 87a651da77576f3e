// How much memory the stages after the poses hold at most: what `--memory` compares.
#pragma once

#include <cstddef>

#include "core/geometry/geometry.h"

namespace ldp {

struct ExpectedMemory {  // bytes, of the whole process
  size_t all = 0;
  size_t least = 0;  // when large arrays may live in a scratch space
};

// From the grid on which depths are found, the columns of colour to each of its columns, the pixels of one photo and of
// all upright frames together, and the layers.
ExpectedMemory expected_memory(const PanoramaGrid& grid, int columns_of_colour, size_t photo_px, size_t upright_px,
                               int layers);

}  // namespace ldp
