// What was tuned in colour: unit, meaning, range. What a caller may choose is in ColourOptions.
#pragma once

#include <cstddef>

namespace ldp::colour::tuning {

// Candidates of a pixel (source_candidates.cpp).
constexpr int kMaxCandidates = 8;  // the cameras nearest to the ray among those that see the voxel, 1 .. 16
constexpr int kNoise = 3;          // levels by which samples of one surface may differ
constexpr int kMostDiffer = 60;    // levels; what differs more is just another surface

// Samples at local exposure (photo_sampler.h).
constexpr double kUnclipped = 236, kClipped = 252;  // levels of the largest channel: it is not cut off, it is
constexpr double kClippedDarker = 0.5;              // share of light taken away where that matters in full, 0 .. 1

// Blending (blending.h).
constexpr int kCompareEvery = 4;               // pixels, both ways: enough to compare photographs' brightness
constexpr int kBrightnessCellPx = 64;          // at most, spread evenly over the panorama
constexpr size_t kBrightnessLeastSamples = 8;  // of a cell that is known

// Seam levelling (seam_levelling.h): its equation's k is 1, for a full side between two cells.
constexpr int kLevellingSweeps = 120;  // of Gauss-Seidel; offsets decay within about ten cells
constexpr int kLargestStep = 40;       // grey levels; larger ones are another object, not another exposure
constexpr double kSeamWeight = 0.1;    // of one sample on a border
constexpr double kOffsetDecay = 0.02;  // e: pull of a full cell's offset towards zero

}  // namespace ldp::colour::tuning
