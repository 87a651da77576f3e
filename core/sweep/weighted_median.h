// Edge-preserving smoothing of disparity: the median of a window, its pixels weighted by how alike their greys are,
// then the mean of what lies beside that median. Outlines move to the image's edges, and surfaces lose the noise of
// matching. (Weighted median filters for stereo: Ma et al., ICCV 2013.)
#pragma once

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/disparity.h"

namespace ldp::sweep {

// Pixels of kNoDisparity stay and are not looked at. `guide` has the map's size; `wraps`: columns are modulo the width.
DisparityMap smooth(const DisparityMap& disparity, const Plane<uint8_t>& guide, bool wraps, const Job& job);

}  // namespace ldp::sweep
