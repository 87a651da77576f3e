// What was tuned in the sweep: unit, meaning, range. What was tried, and what it gave, stands in decisions.md; what a
// caller may choose is in SweepOptions, what the kernels' equations hold in sweep_kernels.h.
#pragma once

namespace ldp::sweep::tuning {

// Which cameras see a voxel well enough to be compared (voxel_lines.h).
constexpr double kLeastCosine = 0.3;  // between the ray and the camera's axis, 0 .. 1: 72 degrees
// Of the cameras nearest to a ray from first to last, over the range of depths, as a tangent; with less, others are
// compared that stand so far apart together; .2 .. .4.
constexpr double kLeastParallax = 0.28;
constexpr double kLargestStep = 4;  // photo rows per panorama row, above 1; beyond, a voxel is too near to the camera

// Plain parts (cost_volume.h): where the reference is plain over all that a cost depends on, labels differ by what
// photographs of one surface differ by: reflections, shading, noise. Costs that exceed the least by no more are equal,
// and smoothness decides.
constexpr int kPlainContrast = 4, kNoLongerPlain = 6;  // grey levels, the first below the second: fully so, not at all
constexpr int kPlainDifference = 16;                   // in 1/kCostScale grey levels, 0 .. 254

// Feature points (points_prior.h): where the reference is nearly plain, labels cost more the farther they lie from what
// feature points around tell. Smoothness alone would let a wide plain surface lie anywhere.
constexpr int kPointsContrast = 12,
              kPointsFullContrast = 6;                     // grey levels, the second below the first: not at all, fully
constexpr int kPointsLabelsPerUnit = 2;                    // labels off that cost a unit of 1/kCostScale, above 0
constexpr int kPointsSlack = 1, kPointsMost = 6;           // labels off that cost nothing, and that cost most
constexpr int kPointsCellPx = 8;                           // side of the cells that have an expectation
constexpr double kPointsReachPx = 80, kPointsNearPx = 24;  // of a point; at the second it counts a quarter
constexpr int kPointsMostViews = 3;                        // what further cameras than these and one see counts no more
constexpr double kPointsSpread = 0.3;  // labels by which points differ where what they tell counts half

// Disparity between labels (depth_refinement.cpp).
constexpr int kFineSteps = 8;  // a label
constexpr int kFineReach = 6;  // fine steps either side of the label's middle that are tried, up to kFineSteps

// Weighted median (weighted_median.h).
constexpr int kMedianDecay = 217;  // of 256: weight that each grey level of difference leaves, exp(-1/6)

// Weak membrane (weak_membrane.h).
constexpr int kMembraneRounds = 20;
constexpr int kStrongestTie = 25;  // of neighbours of one grey, against firmness as depth_refinement.cpp measures it
constexpr int kTieDecay = 239;     // of 256: tie that each grey level of difference leaves, exp(-1/15)
constexpr int kMembraneContrastReach = 3;   // pixels around one over which the guide's contrast is taken
constexpr int kMembranePlainContrast = 24;  // grey levels up to which these are plain
constexpr int kLabelBreaks = 6;             // a tie breaks at a label divided by this

// Near bound (matched_near): the grid is looked at in strips of columns, cut into square blocks.
constexpr int kNearBlock = 8, kNearStripEvery = 64;    // pixels
constexpr double kNearFarthestIn = 1.5;                // times the range's near bound, above 1
constexpr int kGlanceLabels = 8, kGlanceSubsteps = 3;  // of the first look, at nearer depths alone
constexpr int kNearMatches = 20, kNearLess = 10;       // in 1/kCostScale grey levels: what matches, and by how much
                                                       // less it costs than anything within the range
constexpr int kNearMostOfBlock = kNearBlock * kNearBlock * 3 / 4;  // pixels
constexpr double kNearLeastShare = 0.00125;                        // of the blocks looked at, and at least
constexpr int kNearLeastBlocks = 4;
constexpr double kNearHeld = 0.8;  // of the blocks that match nearer

}  // namespace ldp::sweep::tuning
