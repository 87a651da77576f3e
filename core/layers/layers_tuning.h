// What was tuned in this stage: unit, meaning. What a caller may choose is in LayersOptions.
#pragma once

#include <cstddef>

namespace ldp::layers::tuning {

// Where silhouettes are cut (silhouettes.cpp).

constexpr int kReachPx = 12;                     // an outline moves inwards by at most so much
constexpr double kApartPx = 4;                   // surfaces have an outline where parallax between them exceeds this
constexpr int kMostViews = 7;                    // cameras that a voxel is asked in, at least 2
constexpr int kGreySteps = 16;                   // of tones, to a grey level
constexpr int kGreyNoise = 2 * kGreySteps;       // that two samples of one surface may differ by
constexpr int kTintNoise = 4 * kGreySteps;       // chroma is coarser in photos
constexpr int kMostDiffer = 40 * kGreySteps;     // what differs more is just another surface
constexpr int kMargin = kGreySteps;              // by which photographs must prefer the farther surface
constexpr int kSmoothness = 3 * kGreySteps / 4;  // gain of each of the eight neighbours on one's own surface

// What a hidden surface farther than all that shows around it costs more (background.cpp), in 1/kCostScale grey levels.
constexpr int kUnlikelyPrice = 32;

// Which of two depth maps the photographs contradict less (proposal_fusion.cpp).
constexpr double kFusionApartPx = 2;  // surfaces differ where parallax between them exceeds this
constexpr double kRoughApartPx = 8;   // what is apart by more parallax is not rougher still

// What is lighter or darker than what is around it (proposals/lightness.cpp): by more than so many grey levels.
constexpr int kLightnessDiffers = 4;

// Planes that a depth map is put onto (proposals/plane_fits.cpp).
constexpr int kPlaneSquarePx = 48;         // they are fitted to squares of so many pixels
constexpr double kOnPlanePx = 2;           // parallax by which what lies on one may be off it
constexpr double kLeastPlaneShare = 0.5;   // 0 .. 1, of a square's present samples that must lie on its plane
constexpr double kOtherPlanePx = 6;        // parallax: what is farther off than this is another surface
constexpr int kPlaneTries = 48;            // of three samples each
constexpr size_t kLeastPlaneSamples = 30;  // in a square
constexpr int kLeastPlaneArea = 50;        // of the parallelogram of three samples, square pixels

// Steps in plain parts (proposals/plain_tears.cpp).
constexpr int kPlainTearContrast = 12;  // grey levels between the darkest and the brightest of what is plain
constexpr double kTearPx = 6;           // parallax: a step is more than this,
constexpr int kTearPlainPx = 8;         // and all is plain so far around both of its sides
constexpr int kSlopePx = 20;            // pixels that a slope reaches to either side of a step,
constexpr int kSlopePlainPx = 2;        // where all is plain so far around each
constexpr int kSlopeRounds = 80;        // of means of four: they spread by sqrt(rounds / 2) pixels

// What matches best without smoothness (proposals/unsmoothed.cpp): by more than this, in 1/kCostScale grey levels.
constexpr int kClearlyCheaper = 4;

// How photographs contradict a surface (photo_consistency.h).
constexpr size_t kWitnesses = 4;                            // cameras next to one that are asked
constexpr double kWitnessCosine = 0.3;                      // between their axes at least: 72 degrees
constexpr int kWitnessNoise = 1;                            // grey levels that samples of one surface may differ by
constexpr int kWitnessPartOfPx = 4;                         // by one part of so many a pixel may lie beside its place
constexpr int kWitnessMostDiffer = 24;                      // grey levels: what differs more is just another surface
constexpr int kDifferenceSteps = 16;                        // to a grey level
constexpr int kUnknownDifference = 6 * kDifferenceSteps;    // of what no other camera sees
constexpr int kUncoveredDifference = 2 * kDifferenceSteps;  // more, where only what goes on from beside shows
// By so much less must all cameras contradict a proposal, summed over what is decided on together: less is noise. (This
// and the next two are of all columns, and less where fewer are compared.)
constexpr int kPreferred = 7 * kDifferenceSteps;
constexpr int kSimplerAllowed = 30 * kDifferenceSteps;  // by so much more they may contradict what is simpler
// What a pixel's being apart by kRoughApartPx from one of its four neighbours weighs against that.
constexpr int kRoughness = 3 * kDifferenceSteps;

}  // namespace ldp::layers::tuning
