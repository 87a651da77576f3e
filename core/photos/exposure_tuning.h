// Tuned constants of exposure compensation, and of the curve by which a gain is applied. Levels are those of 8-bit
// channels, 0 .. 255.
#pragma once

#include <cstddef>

namespace ldp::exposure {

// Compensation (exposure_compensation.h).
constexpr int kBlocksAcross = 64;            // thumbnail blocks along the longer side of a photo, from 8
constexpr int kLowest = 16, kHighest = 240;  // levels between which a pixel is trusted: beyond, channels clip
constexpr double kLeastForward = 0.1;  // cosine to a camera's forward axis, 0 .. 1, from which a direction is looked up
constexpr size_t kLeastSamples = 12;   // of a link, from 1
// Prior, standard deviations of logarithms: by how much neighbouring photos differ in exposure (automatic exposure goes
// a stop either way), and each channel in its share of it (white balance).
constexpr double kExposureSigma = 0.5, kTintSigma = 0.1;
constexpr double kLeastLinkSigma = 0.003;  // a link is never trusted more than this
constexpr double kLargestGain = 4;         // factor, from 1; its inverse is the smallest
constexpr int kReweightings = 5;           // of links that contradict the others, from 1
constexpr double kAnchor = 1e-3;  // pulls each unknown to zero, lest photos without links have no solution; above 0

constexpr double kWhite = 255;

// The curve (exposure_gain.h): from here to white it bends, so that white stays white.
constexpr double kBrightShoulder = 208;  // of the level that a gain above 1 gives
constexpr double kDarkShoulder = 224;    // of a level under a gain below 1; nearer to white: what is not clipped shall
                                         // match what others show of it

// Calibration (calibration.h). Logarithms are natural ones.
constexpr size_t kSlopes = 8;                        // levels between which the response's slope is linear, from 3
constexpr double kFirstSlope = 16, kSlopeStep = 32;  // those levels: 16 .. 240
constexpr double kMeanSlope = 1 / 2.2;               // of them; above 0
constexpr double kLeastSlope = 0.05;                 // above 0
constexpr double kSlopeBend = 0.05;       // by which a slope differs from the mean of those beside it, times two
constexpr double kLevelSigma = 0.1;       // of the level of one thing in two photographs; beyond, it loses weight
constexpr double kLightTintSigma = 0.1;   // of two photographs' white balance, before they are compared
constexpr int kCalibrations = 10;         // rounds, from 1
constexpr double kLargestLightGain = 15;  // factor, from 1; its inverse is the smallest

// Local exposure (local_exposure.h).
constexpr double kLeastLocalFactor = 1.2;  // by which even exposure may differ from the photographs, from 1
constexpr double kLocalSigma_rad = 0.26;   // angle from a photograph's axis within which it counts, above 0
constexpr double kNode_rad = 0.07;         // between nodes of a field, a third of that, above 0
constexpr int kMostNodes = 256;            // along a side, as a file may have

}  // namespace ldp::exposure
