// Tuned constants of corners, keypoints, descriptors and patches. Tests of sift pin the bytes that the keypoints' give.
#pragma once

namespace ldp::sfm {

// Corners (corners.h).
constexpr int kCornerWindowRadius_px = 3;       // of the structure tensor, 1 .. 10: 7 x 7 gradients are summed
constexpr int kCornerSuppressionRadius_px = 3;  // of non-maximum suppression, >= 1

// Keypoints (scale_space.h, features.h).
constexpr double kOctaveSigma_px = 1.6;        // blur of an octave's first level, pixels of the octave (Lowe 2004)
constexpr double kAssumedBlur_px = 0.5;        // that a picture is taken to have, 0 .. 0.8
constexpr double kMaxCurvatureRatio = 10;      // of an extremum's two curvatures, > 1: beyond, it slides along an edge
constexpr int kMaxLocalisationSteps = 5;       // of an extremum from pixel to pixel, >= 1
constexpr double kMinKeypointContrast = 1.02;  // grey levels, > 0; below Lowe's 3.4: skies and walls have faint
                                               // texture, and it matches
constexpr int kKeypointGridCells = 8;          // each way, >= 1: over which keypoints are spread

// Orientations and descriptors (sift.h), Lowe's values.
constexpr double kOrientationWindowSigmas = 1.5;  // of the window, in units of the keypoint's sigma
constexpr double kSecondOrientationShare = 0.8;   // 0 .. 1, of the highest bin, that makes a second keypoint
constexpr double kDescriptorCellSigmas = 3;       // width of a cell, in units of the keypoint's sigma
constexpr float kMaxDescriptorEntry = 0.2F;       // 0 .. 1, of the descriptor's length, against glare

// Alignment of patches (patch_alignment.h).
constexpr int kMaxAlignmentIterations = 12;      // per pyramid level, >= 1
constexpr double kAlignmentConverged_px = 0.02;  // a smaller step ends it
constexpr double kMaxAlignmentStep_px = 3;       // a larger one has lost the patch
constexpr double kMinPatchContrast = 3;          // grey levels, standard deviation
constexpr double kMinGradientRatio = 0.15;  // 0 .. 0.5, squared gradients of the weaker direction against both: less
                                            // is an edge, along which a patch slides

}  // namespace ldp::sfm
