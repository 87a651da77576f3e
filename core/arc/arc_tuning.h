// Tuned constants of the arc and of the grid laid on it; what was measured: decisions.md.
#pragma once

#include <cstddef>
#include <numbers>

namespace ldp::arcs {

constexpr double kDegree = std::numbers::pi / 180;

// The fit. How far a hand is from the ideal: standard deviations of the axis' witnesses, above 0.
constexpr double kRollSigma_rad = 3 * kDegree;    // a camera's right axis out of the horizontal
constexpr double kPitchSigma_rad = 10 * kDegree;  // its forward axis (people tilt cameras for a whole sweep)
constexpr double kHeightSigma = 0.10;             // camera centres out of the plane, shares of their spread
constexpr double kRadialSigma = 0.02;             // off the circle, shares of their spread
constexpr double kTangentialSigma = 0.20;         // the same along it, against where the camera looks
constexpr double kRoughest = 0.2;  // radii, 0 .. 1: radial residual up to which a path counts as going round
constexpr double kStraightAngle_rad = 8 * kDegree;  // a path that bends less counts as straight
constexpr double kForward =
    0.5;  // cosine of the mean line of sight to a straight path's normal, 0 .. 1: walks have less
// Path lengths, above 0.5; straight paths get it. The rays of a larger circle would run parallel, and what the cameras
// at its ends see aside would lie far beyond the panorama's ends.
constexpr double kLargestRadius = 1.5;
// The circle is rounded to 2^-bits of its radius and of a radian, a hundred-thousandth of a pixel: the last bits of a
// fit depend on the processor. 20 .. 40.
constexpr int kFitBits = 24;

// The grid's rows and columns.
constexpr double kSteepest = 4;        // |v|, the tangent of 76 degrees: a cylinder shows nothing useful beyond
constexpr double kTallest = 1.5;       // times the rows of what is seen far away, from 1
constexpr int kWidest = 65535;         // columns that a file holds (core/panorama/file/FORMAT.md)
constexpr int kMostColourColumns = 2;  // of colour to one of depths, from 1

// Its range of depths.
constexpr double kLowestShare = 0.02;  // of the points, 0 .. 0.5: percentile of inverse depths taken as far and near
// Points that three cameras agree on are hardly ever wrong: a few of them, beyond a percentile, are something that has
// few points, such as a railing nearby, or a garden through a window.
constexpr size_t kSureCameras = 3, kFewestSure = 8;  // cameras, from 2; points
constexpr double kSureShare = 0.001;                 // of all points, and kFewestSure at least
constexpr double kMargin = 1.15;         // factor of the nearest inverse depth, from 1, for what no point was found on
constexpr double kFarRadii = 100;        // radii, beyond which is infinity
constexpr double kFarLabels = 1.5 / 15;  // share of the range; what is no farther from infinity is at it: skies have no
                                         // points
// Found from points and photos, range and borders need no more digits; further ones depend on the processor.
constexpr int kRangeBits = 9;    // of the inverse depths
constexpr int kBorderBits = 20;  // of a radian

// Cameras that look along their way (sideways).
constexpr double kClearly = 2;           // times as much up or down as to the side, from 1
constexpr double kLeastTurn_rad = 0.25;  // below which a turn tells nothing
constexpr double kLeastShare = 0.35;     // of the path's length, 0 .. 1, that must remain of its steps' sum

}  // namespace ldp::arcs
