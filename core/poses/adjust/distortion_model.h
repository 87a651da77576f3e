// Choice of the distortion model: whether a lens has any. Focal length and distortion can stand in for each other in a
// narrow view, and a few things that move are always explained a little better by a lens that distorts; so distortion
// is freed only where that explains clearly more.
#pragma once

#include <optional>

#include "core/poses/adjust/bundle_adjustment.h"

namespace ldp::sfm {

// By how many variances of an observation free distortion must lower the cost of the bundle to be believed: on tracks
// by KLT, which are exact to a tenth of a pixel, less than on matches.
double min_distortion_gain(const Bundle& bundle, bool on_klt_tracks);

// The bundle (adjusted with `options`, at that cost) adjusted with distortion free, if that lowers the cost by so many
// variances.
std::optional<Bundle> adjust_with_distortion(const Bundle& bundle, BundleAdjustmentOptions options, double cost,
                                             double min_gain, const Job& job);

}  // namespace ldp::sfm
