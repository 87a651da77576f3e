// Takes most of the slow shading out of one plane of a photo, keeping its texture and the order of its surfaces, so
// that reflections that move with the camera, vignetting and what exposure gains leave over do not look like depth.
//
// Takes and gives a plane of kSampleScale times 8-bit values: out = in - 0.8 (base - 128), clamped, where base is the
// bilateral mean: of pixels near by whose value is near too, so that a surface's mean does not depend on what stands
// behind it in this photo (background subtraction by bilateral filtering: Ansar, Castano, Matthies, 3DPVT 2004;
// found best among simple filters by Hirschmueller and Scharstein, PAMI 2009).
// How: a bilateral grid (Chen, Paris, Durand, SIGGRAPH 2007) in integers: cells of 1/64 of the photo's longer side by
// 12 grey levels, smoothed by [1 2 1] along its three axes, read by trilinear interpolation.
#pragma once

#include <cstdint>

#include "core/base/job.h"
#include "core/base/plane.h"

namespace ldp::rectification {

Plane<uint16_t> flatten(const Plane<uint16_t>& grey, const Job& job);

}  // namespace ldp::rectification
