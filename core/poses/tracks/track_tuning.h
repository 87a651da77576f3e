// Tuned constants of matching, track merging, triangulation and tracking. Where a unit is "pixels of 800", it is pixels
// of a photo whose longer side has 800 (MatchedSweep::pixels).
#pragma once

#include <cstddef>

namespace ldp::sfm {

// Two-view geometry (geometric_verification.h; more in TwoViewOptions).
constexpr int kPreviewFeatures = 300;      // strongest of each photo that the search for loop closures compares first
constexpr size_t kMinPreviewMatches = 12;  // of them, for a full comparison
constexpr double kRansacConfidence = 0.9999;  // 0 .. 1
constexpr int kMaxRansacIterations = 2000;

// Guided matching (guided_matching.h).
constexpr double kEpipolarBand_px = 3;          // pixels of 800 that a match may miss the epipolar line by
constexpr double kMinGuidedDepth = 0.7;         // radii, > 0: where the part of the line that is searched begins
constexpr double kGuidedRatio = 0.85;           // 0 .. 1, of the distances to the best and the second best on the line
constexpr double kMaxDescriptorDistance = 0.6;  // 0 .. sqrt 2, in units of the descriptors' length
constexpr double kTwinFeature_px = 4;           // pixels of 800: a second best that near is the same thing
constexpr double kMaxGuidedAngle = 0.8;         // 0 .. 1, of the field of view, between the axes of two frames

// Track merging (tracks.h).
constexpr double kSameFeature_px =
    2;  // two features of a frame that near are one thing with two orientations or scales

// Triangulation (triangulation.h, track_triangulation.h, match_graph.h). Inverse distances are in 1 / radii.
constexpr double kMinDepth = 1e-3;       // of a point in camera axes that is still projected
constexpr double kMinDepthShare = 2e-3;  // of its distance from the origin: a point nearer to a camera is in it
constexpr double kMaxInverseDistance = 5, kMinInverseDistance = -0.1;  // of plausible points; noise puts far ones a
                                                                       // little beyond infinity
constexpr double kDefaultInverseDistance = 0.2;                        // of a point that cannot be triangulated yet

// Search along a line of sight (epipolar_search.h). Pixels are those of the photo as it is kept.
constexpr int kSearchMargin_px = 12;                         // between a place that is compared and the border
constexpr int kSearchPatchRadius_px = 5;                     // of half the picture's size
constexpr double kFarQuantile = 0.02, kNearQuantile = 0.98;  // 0 .. 1, of the inverse distances that a frame sees,
                                                             // between which others are tried
constexpr double kNearMargin = 1.2;                          // >= 1: and so much nearer than the nearest of these
constexpr double kSearchStep_px = 1;                         // of half the picture, between places compared
constexpr int kMinSearchSteps = 3, kMaxSearchSteps = 200;
constexpr double kMinSearchCorrelation = 0.7;  // -1 .. 1, the mean of both photos
constexpr double kMaxSearchRatio = 0.7;        // 0 .. 1, of 1 - correlation at the best and the second best peak
constexpr size_t kPeakWidth_steps = 2;         // within which two distances are one peak

// Tracking (klt_tracking.h; more in KltOptions).
constexpr int kSmallPatchRadius_px = 5, kLargePatchRadius_px = 9;  // the large one where as much lies in one plane:
constexpr double kMaxResidualGrowth = 1.2;              // >= 1, of the squared residual over that of the small patch,
constexpr double kMaxPatchShift_px = 0.5;               // and no farther from where the small one was found
constexpr double kMinCoarseCorrelation = 0.5;           // -1 .. 1, on half the picture, to start from there
constexpr double kMinWarpArea = 0.3, kMaxWarpArea = 3;  // determinants of the predicted warp
constexpr size_t kMinAveragedFrames = 3;                // whose average is less noisy than the anchor
constexpr int kTemplateUpdates = 2;                     // each the average of what was aligned with the one before
constexpr double kFeatureSigma_px = 0.3;  // pixels of 800: where a feature is detected, which has weight 1
constexpr double kMinKltSigma_px = 0.06;  // pixels of 800: of the best that is tracked

}  // namespace ldp::sfm
