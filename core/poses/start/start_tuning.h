// Tuned constants of initialisation: rotation averaging over hypotheses of the focal length, incremental
// reconstruction, and which kind of motion it is. "Pixels of 800" are those of a photo whose longer side has 800.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numbers>

namespace ldp::sfm {

// Focal lengths.
constexpr double kMaxView_rad = 125 * std::numbers::pi / 180,
                 kMinView_rad = 8 * std::numbers::pi / 180;  // of the
                                                             // longer side: beyond these hardly any camera's
constexpr double kWidestHypothesis_rad = 105 * std::numbers::pi / 180,
                 kNarrowestHypothesis_rad = 18 * std::numbers::pi / 180;
constexpr int kFocalHypotheses = 10;                                // between these, when nothing is known
constexpr double kGenericFocal = 0.9, kGenericFocalLogSigma = 0.5;  // longer sides: of any camera

// Two views (spherical_motion.h).
constexpr double kSphereTolerance_px = 4;       // pixels of 800: hands leave the sphere
constexpr double kRotationParallax_rad = 0.05;  // how far near things stray from a pure rotation
constexpr double kCameraTurnShare = 0.9,
                 kCameraTurnShareSigma = 0.2;  // of the rotation that the pictures show, the
                                               // camera's own: 1 - the inverse distance, in radii, of what they show
constexpr double kAxisSigma_rad = 0.02, kAxisSigmaShare = 0.1;  // deviation of its axis: jitter, and of the rotation
constexpr double kEffectiveMatches = 20;  // independent ones that all are worth, since what makes them err they share
constexpr int kKabschIterations = 12, kMaxAveragingIterations = 20;
constexpr double kRotationTolerance_rad = 0.1;  // Cauchy scale of disagreement between edges of rotation averaging

// Steps by their pairs alone (step_priors).
constexpr double kStepSigmaShare = 0.2;  // deviation of their angle, of the angle
constexpr double kLeastStep_rad = 0.01;  // which is no less
constexpr double kMaxStepCost = 0.7;     // of RelativeRotation: matches are off by the tolerance, in the mean

// Outlier rejection among pairs (rotation_averaging.h).
constexpr size_t kMatchesPerRotation = 100;     // that estimate a pair's rotation
constexpr double kSequenceDistancePower = 1.5;  // of the distance in the sequence, by which pairs are trusted less
constexpr double kMaxSweep_rad = 3 * std::numbers::pi;                  // by a sweep, summed over its steps
constexpr double kPairTolerance_rad = 0.08, kMinPairInlierRatio = 0.3;  // a pair of which fewer matches agree, so
                                                                        // roughly, contradicts the cameras
constexpr double kMaxPairAngle_steps = 1.5, kMaxPairAngleShare = 0.15;  // or so much between its rotation and theirs,
                                                                        // in mean steps and of theirs
constexpr double kMinLoopClosure_rad = 4 * std::numbers::pi / 3;  // turned between photos that may see the same again
constexpr uint8_t kPossibleVote = 1, kCertainVote = 2;            // for a match; votes of kCertainVote keep it
constexpr double kMaxSphericalInverseDistance = 1;  // of what lies on the circle: an arm looks at what is outside

// Choice between hypotheses (initialisation.h).
constexpr double kStartTolerance_px = 12;  // pixels of 800 within which a hypothesis explains an observation
constexpr double kLoopGapLoss_px = 40;     // and by which a circle may miss its end before all steps share in that
constexpr double kMinFrontShare = 0.5;     // 0 .. 1, of the best one's inliers, that others need
constexpr double kBehindInfinity = -0.02;  // inverse distance of a point that fails the cheirality test
constexpr int kStartObservationsPerFrame = 50;
constexpr int kStaticCandidates = 2 * kStartObservationsPerFrame;  // of a frame, the longest tracks first, of which
constexpr double kStaticTolerance_px = 24;  // those are taken that a hypothesis explains within so many pixels of 800
constexpr int kMaxTrackGap = 4;             // frames from one observation to the next of the same part of a track
constexpr size_t kFreedStarts = 3;          // that are adjusted with free centres
constexpr double kStartArcSigma = 0.05;     // of these, radii: a short arc could turn inside out otherwise
constexpr double kSameLogFocal = 0.02;      // starts whose focal lengths differ by less are one

// Incremental reconstruction (incremental_reconstruction.h).
constexpr double kIncrementalTolerance_px = 4;  // pixels of 800
constexpr size_t kMinSharedPoints = 15;         // of a new frame with those already registered
constexpr size_t kInitialPairCandidates = 12;
constexpr double kInitialPairParallax_rad = 0.05;  // median of the pair's points, that makes a good beginning
constexpr double kFreeArcSigma = 1e3;              // radii: the arc prior only fixes what nothing else does
constexpr int kIncrementalObservationsPerFrame = 100;
constexpr int kMinFramesForFocal = 5;  // from which the focal length is adjusted with them
constexpr int kEssentialIterations = 500, kPnpIterations = 300, kIncrementalAdjustmentSteps = 10;
constexpr double kIncrementalConfidence = 0.999;  // 0 .. 1, of RANSAC

// Kind of motion (motion_model.h).
constexpr double kMaxParallaxShare = 0.1;       // of the observations, in what still counts as a rotation
constexpr double kParallax_px = 1.5;            // pixels of 800 by which a point must miss a rotation to show parallax
constexpr double kShaking_px = 5;               // pixels of 800 by which a shaking hand moves most near things at most
constexpr double kMaxShakingShare = 0.15;       // 0 .. 1, of the observations, beyond that in a false arc, and
constexpr double kMaxShakingPerLogFocal = 0.6;  // that share over the logarithm by which the focal lengths differ,
constexpr double kMinFalseArcLogFocal = 0.03;   // which is no less
constexpr int kParallaxObservationsPerFrame = 60;
constexpr double kMinArcShare = 0.5;   // 0 .. 1, of the centres' spread that turning must explain in an arc
constexpr double kMinArc_rad = 0.14;   // that a path must turn to be an arc
constexpr int kMinSeamTracks = 5;      // points seen on both sides of the seam of a closed sweep
constexpr double kMaxClosedGap = 0.6;  // of the field of view, that may be missing where a sweep closes

}  // namespace ldp::sfm
