// Exposure compensation by gains: one factor per photograph and channel that makes overlapping photographs agree
// (hand-held cameras drift in exposure and white balance during a sweep).
//
// Takes thumbnails of block means; compares blocks of photos that look at the same direction (and, where there are
// scene points, at the same point). A link's ratio is the median over its blocks, so that parallax and moving things
// do not matter; gains solve all links by iteratively re-weighted least squares in logarithms, their mean being 1.
#pragma once

#include <vector>

#include "core/geometry/geometry.h"
#include "core/photos/exposure/overlap_samples.h"
#include "core/photos/exposure_gain.h"

namespace ldp {

std::vector<Gain> exposure_gains(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
                                 const std::vector<ScenePoint>& points);

}  // namespace ldp
