// Tuned constants of the alternation of triangulation and bundle adjustment. "Pixels of 800" are those of a photo whose
// longer side has 800; sigmas of the arc prior are in radii of the cameras' circle.
#pragma once

#include <cstddef>
#include <numbers>

namespace ldp::sfm {

// Iterations (iterative_refinement.h).
constexpr double kCoarseTolerance_px = 12, kMediumTolerance_px = 5,  // pixels of 800, of iterations on matches, from
    kFineTolerance_px = 3;                                           // the first to the last
constexpr double kMatchTolerances_px[] = {kCoarseTolerance_px, kMediumTolerance_px, kFineTolerance_px};
constexpr double kKltTolerances_px[] = {4, 2};             // and on tracks by KLT
constexpr double kTightArcSigma = 0.02, kArcSigma = 0.05;  // at first and later: what walks by is told from what stands
                                                           // as long as cameras are kept near their circle;
                                                           // tracks by KLT may tell of more scatter
constexpr double kWideArcSigma = 0.2;                      // for hands that leave it
constexpr double kNoArcSigma = 1e3;                        // for paths that are none
constexpr int kWellObserved = 150;                         // observations by KLT that a frame is content with
constexpr double kLossPerTolerance = 0.3, kMaxLoss_px = 0.8;  // Cauchy scale; pixels of 800
constexpr double kKltLossShare = 0.7;  // of that, on tracks by KLT: most are far better than the few that are not
constexpr double kMatchTwoViewWeight = 0.2, kKltTwoViewWeight = 0.05;  // 0 .. 1, of points that two photos see, in
                                                                       // iterations before the last: some move, and two
                                                                       // photos of what moves agree on cameras that a
                                                                       // third tells wrong
constexpr double kCoarseFunctionTolerance = 1e-4,  // of iterations whose points the next triangulates anew,
    kMediumFunctionTolerance = 1e-5,               // of those before KLT,
    kFineFunctionTolerance = 1e-6;                 // and of the last
constexpr double kTrackScale_px = 1;               // pixels of 800, Geman and McClure's scale in the last iteration
constexpr double kMinNoise_px = 0.01;              // pixels of 800: nothing is seen more exactly
constexpr double kDepthOutlier_px =
    12;  // pixels of 800 of parallax that a point of two photos may differ from all around

// Smooth motion (smooth_motion.h).
constexpr int kCoarseObservationsPerFrame = 250;           // that do for the first iterations, the longest tracks first
constexpr double kSmoothArcSigmas[] = {0.02, 0.01, 0.02};  // of the arc prior, by iteration
constexpr double kSmoothnessTradeOff =
    1.0 / 3;                              // 0 .. 1, of the inliers, that may be given for motion without roughness
constexpr double kBrokenStepShare = 0.5;  // 0 .. 1, of others' inliers across a step: with less it is broken
constexpr int kMinTracksAcrossStep = 30;  // from which their loss tells something

// Conditioning of the swept angle (arc_conditioning.h).
constexpr double kMaxArcError_rad = 2.75 * std::numbers::pi / 180;  // if one point alone compared each two steps

// Corner tracks (corner_tracks.h).
constexpr int kWantedCorners = 3000;  // tracks through a frame: hardly ever so many
constexpr double kTriedPerWantedCorner = 3;
constexpr int kCornerGridCells = 8;         // each way, over which what is tried spreads:
constexpr int kMaxCornerCellShare = 2;      // a cell has no more than so many times its even share
constexpr double kMinCornerSpacing_px = 4;  // pixels of 800 between a corner and whatever else three see in its frame
constexpr double kDuplicateTrack_px = 3;    // pixels of 800: two tracks that come as near in a frame show one thing
constexpr size_t kMinCornerViews = 3;       // photos that must show a corner

// Resection (resection.h).
constexpr double kResectionTolerance_px = 12;  // pixels of 800 that a match may miss the cameras by
constexpr double kLostInlierRatio = 0.3;       // 0 .. 1, of a frame's matches, or fewer, where it is lost
constexpr double kMinResectionMatches = 60;    // of a frame, from which that tells something

}  // namespace ldp::sfm
