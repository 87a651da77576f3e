// Tuned constants of the estimate: how each part of a build grows with the pixels of its photos. Measured:
// decisions.md.
#pragma once

#include <cstdint>

namespace ldp::estimate {

constexpr int64_t kSmallPixels = 80'000;  // of a photo of the small build
// That the small build has more of where the photos that small could not be posed, again and again up to their size.
constexpr int kMorePixels = 4;
constexpr int kPosesSide_px = 1000;  // longer side of a photo beyond which poses take no longer
// A part that grows with pixels as pixels^x. Features per photo are bounded, and much of the poses' time is of them.
constexpr double kPosesGrowth = 0.36;
constexpr double kFileGrowth = 0.81;  // the finer a picture is, the smoother
constexpr int kLoads = 4;             // of each photo by one build: poses, rectification, colours, comparison

}  // namespace ldp::estimate
