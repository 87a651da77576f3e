// What was tuned where silhouettes are cut (silhouettes.cpp): unit, meaning. What a caller may choose is in
// LayersOptions.
#pragma once

namespace ldp::layers::tuning {

constexpr int kReachPx = 12;                     // an outline moves inwards by at most so much
constexpr double kApartPx = 4;                   // surfaces have an outline where parallax between them exceeds this
constexpr int kMostViews = 7;                    // cameras that a voxel is asked in, at least 2
constexpr int kGreySteps = 16;                   // of tones, to a grey level
constexpr int kGreyNoise = 2 * kGreySteps;       // that two samples of one surface may differ by
constexpr int kTintNoise = 4 * kGreySteps;       // chroma is coarser in photos
constexpr int kMostDiffer = 40 * kGreySteps;     // what differs more is just another surface
constexpr int kMargin = kGreySteps;              // by which photographs must prefer the farther surface
constexpr int kSmoothness = 3 * kGreySteps / 4;  // gain of each of the eight neighbours on one's own surface

}  // namespace ldp::layers::tuning
