// Tuned constants of the pose stage as a whole. "Pixels of 800" are those of a photo whose longer side has 800.
#pragma once

#include <cstddef>
#include <numbers>

namespace ldp::sfm {

constexpr double kFovLogSigma = 0.15;        // of the logarithm of a focal length that someone told
constexpr double kExifLogSigma = 0.05;       // of one that EXIF tells
constexpr double kMaxToldFocalError = 0.15;  // of the one found: beyond, what was told is of another lens or crop
constexpr int kWorkingSide_px = 1000;        // longer side of what is kept of a photo
constexpr double kMaxPointDistance = 1e4;    // radii, or spreads of known cameras: points are put no farther

// Photos taken densely (unfit_frames.h): what nearly the same pictures add is work.
constexpr size_t kManyFrames = 40;  // as many are taken whatever they show; 30 .. 60
// Of the longer side, that neighbours move by at least: the first that leaves as few, or the last.
constexpr double kDenseSteps[] = {0.0025, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05};

// Order of the reconstruction (reconstruct.h).
constexpr int kMinPosedFrames = 3;
constexpr int kMinFrameObservations = 12;  // that hold a frame in place
constexpr double kWideArcGain = 1.1;       // >= 1: by so much more must cameras off the circle explain
constexpr double kIncrementalGain = 1.2;   // >= 1: by so much more must incremental reconstruction explain
constexpr double kRestartGain = 1.05;      // the same where it turns out to be an arc after all
constexpr double kMinExplainedShare = 1 / kIncrementalGain;  // of the observations, else other motion is tried
constexpr double kMinConnectedInlierRatio = 0.3;             // 0 .. 1, of a pair's matches must agree
constexpr double kConnectedTolerance_px = 12;       // within so many pixels of 800 for it to connect its frames
constexpr double kMaxOutlierPairShare = 0.05;       // of all matches may be in pairs that do not
constexpr size_t kRichObservationsPerFrame = 1000;  // that make guided matching needless
constexpr double kMinKeptShare = 0.9;     // of the inliers among matches, that an iteration on tracks by KLT must keep
constexpr double kRuinedShare = 0.5;      // and of less than that none is kept
constexpr double kMaxBeyondShare = 0.15;  // 0 .. 1, of the points beyond, from which points are kept on this side
constexpr int kMaxKltIterations = 4;      // at the wider tolerance, until the focal length
constexpr double kFocalConverged = 5e-4;  // changes by no more than this share

// Second reconstruction (coverage.h).
constexpr int kCoverageGrid = 10, kSpreadTrackGrid = 6;  // cells of a photo, each way
constexpr double kMinCoveredShare = 0.8;   // 0 .. 1, of the cells with matches, that points should explain
constexpr double kMinCoverageGain = 1.02;  // >= 1: so many times as many must the second one explain
constexpr double kNarrowView_rad = 40 * std::numbers::pi / 180;  // of the longer side: a wide lens that bends may
constexpr double kWideFocal = 0.6, kWideFocalLogSigma = 0.2;     // pass for less; longer sides, of such a one
constexpr double kMinLensGain = 1.07;  // >= 1: so many times as many cells must the one lens explain, or the other one

// Known cameras.
constexpr double kKnownCameraTolerance = 0.005;  // of the longer side: given cameras may be a centimetre off
constexpr int kKnownCameraNeighbours = 4;        // that each frame is matched with, nearest line of sight first
constexpr double kKnownCameraOverlap = 1.8;      // of half the diagonal view, between axes of frames that are matched
constexpr int kMinJudgedMatches = 50;            // below which nothing is said of the cameras
constexpr double kMinAgreement = 0.25;           // 0 .. 1, of the matches, with cameras that are not doubted
constexpr double kMinTurnedAgreement = 0.5;      // 0 .. 1, of the matches, with cameras whose axes are turned round
constexpr double kMaxUprightShare = 0.8;         // of that, with the cameras as given
constexpr double kStillQuantile = 0.98, kStillParallax_px = 0.5;  // of all points: nothing shows more at one place

// Doubts (pose_doubt.h).
constexpr double kDoubtTolerance_px = 4;    // pixels of 800 that a match may miss the poses by
constexpr int kDoubtSequenceDistance = 2;   // frames between photos of a pair; farther ones share little, and repeated
                                            // things pass for matches there though the poses are true
constexpr size_t kMinDoubtMatches = 30;     // of a pair, from which its disagreement tells something
constexpr double kMinPairAgreement = 0.5;   // 0 .. 1, of a pair's matches with the poses
constexpr int kMinBridgingPoints = 12;      // that tie a photo to those before it
constexpr int kBridgeSequenceDistance = 4;  // photos before and after that count for it
constexpr int kFirmlyObserved = 8;          // points seen before, in and after a photo, that tie its two steps together
constexpr double kLeastFullTurn_rad = 5;    // that a sweep has turned, to close on itself
constexpr double kSeamOverlapAngle = 0.5;   // of the field of view: its last photo turned from the first by less
constexpr double kSameViewAngle = 0.25;     // of the field of view: photos turned by less show the same
constexpr double kSamePlaceShare = 0.1;     // of the distance of points in the median: and stand nearer than this

}  // namespace ldp::sfm
