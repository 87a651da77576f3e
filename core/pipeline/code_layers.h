// From disparities to the layers of the panorama, without their colours yet.
#pragma once

#include <vector>

#include "core/base/source_map.h"
#include "core/geometry/geometry.h"
#include "core/layers/layers.h"
#include "core/panorama/panorama.h"

namespace ldp {

// Depth codes and coverage of each layer, front to back, on the grid of colours, whose every column of depth was split
// into `columns_of_colour`. What a renderer could not tell from the surface in front of it is dropped, and so are
// specks of layers behind: from `layers` and `sources`, too.
std::vector<Layer> code_layers(const PanoramaGrid& grid, int columns_of_colour, int block_px,
                               std::vector<DisparityMap>& layers, std::vector<SourceMap>& sources);

}  // namespace ldp
