// Tuned constants of the estimate: how each part of a build grows with the pixels of its photos. Measured:
// decisions.md.
#pragma once

#include <cstdint>

namespace ldp::estimate {

constexpr int64_t kSmallPixels = 80'000;  // of a photo of the small build
// That the small build has more of where photos that small agree at no depth, again and again up to their size.
constexpr int kMorePixels = 4;
// Parts of a file that grow with pixels as pixels^x.
constexpr double kColourGrowth = 0.88;  // the finer a picture is, the smoother
constexpr double kDepthGrowth = 1.2;    // small photos do not show what is thin
constexpr int kLoads = 3;  // of each photo by one build after the poses: rectification, colours, comparison

}  // namespace ldp::estimate
