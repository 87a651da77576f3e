// Tuned constants of the pipeline that are no options.
#pragma once

#include <cstddef>

namespace ldp::pipeline {

constexpr size_t kFewestLevel = 3;  // photos that a panorama is made of without those that look straight up or down
constexpr double kCoarser = 1.05, kCoarsest = 3;  // steps of the panorama's pitch, and its limit, to save memory
// Photos' rows to a row of the panorama where the camera walked along its line of sight, from 1: what such photos share
// is seen at ever other scales, every one of them sees most of it, and the verdict is to sweep again.
constexpr double kWalkPitch = 2.5;
// Share of a grid, one by this, that no photo sees and that is worth leaving out of the sweep: other windows of the
// solver give other depths, as good but for chance.
constexpr int kWorthLeavingOut = 4;
constexpr int kLeastSeen = 20;  // rows and columns at the sides are cut of which less than one by this is seen
constexpr double kFull = 0.75;  // share of the memory allowed at which large arrays are let go: it takes a moment
// Message passing of every cut.
constexpr int kIterations = 4;
// What an iteration before the last finds only hides voxels: it is swept in fewer steps, with less message passing, and
// not expanded at all. Views are as good as with all of it, for half of its time (with 4, 2 and 1 iterations garden
// 20.27, 20.28, 20.26 dB, redkitchen_arc 22.96, 23.03, 23.03, desk_sweep 20.34, 20.51, 20.44).
constexpr int kHidingSubsteps = 4, kHidingIterations = 2, kHidingCycles = 0;
// Parallax over one arc radius to which depths are known; behind the front, where fewer cameras see, to twice as much.
constexpr double kKnownPx = 2.5;
// What lies less behind the surface in front of it is not kept: within the viewing space it shows by half as much, as a
// rim that a renderer gets by letting the background go on underneath.
constexpr double kSeparatePx = 10;
constexpr int kBehindLikelyPx = 64;  // a hidden surface is mostly no farther than all that shows so near
constexpr int kBehindMedianPx = 3;   // layers behind are smoothed over squares that reach so far from each pixel
constexpr int kSpeckPx = 8;          // parts of layers behind that hold fewer pixels are not kept
// The photographs choose between depth maps by what changes within so many pixels: between those of two iterations, and
// between the surface of a pixel and others around it (effort.h).
constexpr int kIterationsReachPx = 12, kPropagationReachPx = 1;
constexpr int kLightnessReachPx = 16;  // of what is around a pixel that is lighter or darker
constexpr int kUnsmoothedPx = 40;      // parts of what matches best without smoothness, of fewer pixels, are chance
// Parts of the front layer, apart from all around them, that hold fewer pixels: noise; noise where the photographs do
// not say otherwise, by what they tell within a few pixels.
constexpr int kFrontSpeckPx = 30, kDoubtfulPx = 150, kDoubtReachPx = 2;
constexpr int kSilhouettePx = 4;  // by so much the sweep's windows may widen a near surface, and the cut a little more

}  // namespace ldp::pipeline
