// Cuts a panorama down to the box of what photographs see.
#pragma once

#include <vector>

#include "core/base/cost_source.h"
#include "core/base/plane.h"
#include "core/base/source_map.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"

namespace ldp {

// The box left when rows and columns of which less than one by kLeastSeen is present in any layer are taken off the
// four sides; of a panorama that wraps, rows only. All of it where nothing is present.
Window seen_box(const std::vector<DisparityMap>& layers, bool wraps);

// Each has one plane a layer, of the grid's size.
struct FoundLayers {
  std::vector<DisparityMap>& disparities;
  std::vector<SourceMap>& sources;
  std::vector<Plane<uint8_t>>& neighbours;
};

// Cuts all planes to that box; gives the grid of what is left.
PanoramaGrid crop_to_seen(const PanoramaGrid& grid, FoundLayers found);

}  // namespace ldp
