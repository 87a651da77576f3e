// Whether a lens bends lines. Focal length and distortion can stand in for each other in a narrow view, and a few
// things that move are always explained a little better by a bent lens; so distortion is freed only where that explains
// clearly more.
#pragma once

#include <optional>

#include "bundle.h"

namespace ldp {

constexpr double kBends = 100;         // variances of an observation by which freeing it must lower the cost, and once
constexpr double kBendsFollowed = 60;  // points are followed, which leaves fewer that move

// The bundle (adjusted with `options`, at that cost) adjusted with distortion free, if that lowers the cost by so many
// variances.
std::optional<Bundle> bent_lens(const Bundle& bundle, BundleOptions options, double cost, double variances,
                                const Job& job);

}  // namespace ldp
