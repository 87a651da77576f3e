// Tuned constants of bundle adjustment (more in BundleAdjustmentOptions) and of the outlier rejection around it.
// "Pixels of 800" are those of a photo whose longer side has 800.
#pragma once

#include <cstddef>

namespace ldp::sfm {

// Bundle adjustment (bundle_adjustment.h, reprojection_error.h).
constexpr double kDistortionSigma = 0.1;     // of k1 and k2 about zero
constexpr double kFixedSigma = 1e-8;         // of a parameter that is held where it is
constexpr double kMinCurvatureShare = 0.65;  // 0 .. 1, of the loss's slope that its curvature leaves (1: as Ceres)
constexpr double kMaxLogFocal = 14;          // of a focal length in pixels: beyond, a step went astray
constexpr double kBehindResidual_px = 1e3;   // of a point behind the camera

// Outlier rejection by depth (depth_outliers.h).
constexpr size_t kDepthNeighbours = 6;          // nearest in the picture that are asked
constexpr int kMinSimilarNeighbours = 2;        // of these must be as far
constexpr double kMaxDepthOutlierShare = 0.25;  // of all points: where more seem so, it is the cameras that are wrong
constexpr double kSameImagePoint_px = 2;        // nearer than that, it is the same thing found twice

// Choice of the distortion model (distortion_model.h): variances of an observation by which free distortion must lower
// the cost. Matches are explained a little better by any lens that bends; so are tracks by KLT, the more the more they
// are.
constexpr double kMinDistortionGain = 100;
constexpr double kMinKltDistortionGain = 7, kKltDistortionGainPerObservation = 1e-3;

// Tracks weighed as a whole (robust_tracks.h).
constexpr double kNoLoss_px = 1e6;                                  // the tracks' weights are all there is
constexpr double kNarrowScale_px = 0.3, kComparisonScale_px = 0.5;  // pixels of 800: the deviation of a feature, and
                                                                    // the scale at which cameras are compared
constexpr double kMinNarrowGain_px2 = 30 * kNarrowScale_px * kNarrowScale_px;  // thirty variances of a feature
constexpr double kWideTrustRegion = 1e6;  // Ceres' initial radius, where what few points tie is to move
constexpr int kTrackReweightings = 3, kStepsPerReweighting = 3;  // weights hold for no more steps
constexpr int kNarrowReweightings = 10, kStepsPerNarrowReweighting = 6;

}  // namespace ldp::sfm
