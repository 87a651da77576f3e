// The expected quality of new views, estimated from what is measured on the sweep and its panorama.
//
// PSNR is about that of the photographs rendered back, less what that cannot tell: how much of the photographs' own
// faults the panorama repeats (blur, noise), and how wrong poses and depths may be between photographs. A linear
// estimate that ends softly at the PSNR of views that have nothing to do with the place. Weights are robust estimates
// over synthetic sweeps, good and spoiled, whose new views are known (tests/bench/verdict_bench; decisions.md).
#pragma once

#include <array>
#include <cstddef>

#include "core/verdict/evidence.h"

namespace ldp {

enum class Feature : uint8_t {
  one,
  back,          // PSNR of the panorama rendered into its photographs [dB]
  beside,        // by how much the photograph beside shows its surfaces worse than it does [dB]
  plain,         // 255 over the differences of neighbouring pixels [dB]
  dark,          // factors of two that photographs are darker than well exposed ones
  blur,          // of the axis that is blurred more, beyond what sharp photographs have
  reprojection,  // root mean square, in thousandths of the photograph's longer side, beyond 1
  shift,         // from photograph to photograph, in widths, beyond what three quarters of overlap have
  flat,          // factors of two by which parallax is less than a sweep's
  outward,       // share of the parallax that points away from the middle of the photographs, beyond half
  doubtful,      // 1 where the poses are
  mismatch       // logarithm of how much more, or less, photographs shift than the poses turn
};
constexpr size_t kFeatures = 12;
using Features = std::array<double, kFeatures>;
inline double& at(Features& features, Feature feature) { return features[static_cast<size_t>(feature)]; }
inline double at(const Features& features, Feature feature) { return features[static_cast<size_t>(feature)]; }

// Of the whole sweep, or of one of its directions.
Features features_of(const SweepEvidence& evidence);
Features features_of(const SweepEvidence& evidence, size_t direction);

// [dB], in hundredths.
double expected_view_psnr(const Features& features);

// PSNR of a mean squared error, at most 60 dB, in hundredths.
double psnr_of(const SquaredError& error);

// What the sweep as a whole tells of its poses.
struct MotionMeasures {
  double parallax = 0;  // root mean square of what turns leave of the points' flow, tangent of an angle; 0 = not known
  double outward = 0;   // share of it that points away from the middle, or of the way forward if less, 0 .. 1
  double mismatch = 0;  // as Feature::mismatch
};
MotionMeasures motion_of(const SweepEvidence& evidence);

}  // namespace ldp
