// What photographs show of a layer's pixels, for what asks whether they look alike.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/photos/upright_frame.h"

namespace ldp::layers {

constexpr int16_t kUnknownGrey = -1;

// Grey of each pixel of the layer as the camera next to its ray shows it; kUnknownGrey where that shows nothing, and
// where the layer is absent. Stored column by column: the plane's rows are the panorama's columns.
Plane<int16_t> front_greys(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& layer,
                           const Job& job);

}  // namespace ldp::layers
