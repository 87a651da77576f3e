// Tuned constants of rectification.
#pragma once

#include <cstddef>

namespace ldp::rectification {

// Upright cameras (resample.h).
constexpr double kMaxUprightTangent = 2.0;  // 63 degrees off the upright axis; beyond, a photo is cut; above 0
constexpr double kMinLevelForward = 0.2;    // sine of the angle between line of sight and axis; .1 .. .5
constexpr int kOutlineSteps = 32;           // points per side by which a photo's outline is followed, from 1

// Background subtraction: a bilateral grid of levels.
constexpr int kCellsAcross = 64;  // along the longer side, from 2
constexpr int kBinLevels = 12;    // of 255, a cell's depth, from 1

// Work done at a time.
constexpr int kStrip = 32;                                      // columns resampled between two looks at the job
constexpr int kRowsAtOnce = 16;                                 // of background subtraction
constexpr size_t kBytesPerPixel = 10, kBytesAtOnce = 32 << 20;  // of photos being worked on
constexpr int kMostTaps = 4;  // samples along an upright pixel's side, 1 .. 4, of photos much finer than the grid

}  // namespace ldp::rectification
