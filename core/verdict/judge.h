// Judges a sweep by the evidence that its photographs, its poses and its panorama rendered back give: the expected
// quality of new views, whole and by direction, and what to do better. What is wrong with the sweep itself is told
// before.
#pragma once

#include "core/verdict/evidence.h"
#include "core/verdict/sweep_quality.h"

namespace ldp {

// Beyond the first bound a reason is told and the sweep is fair, beyond the second it is to be taken again.
struct Bounds {
  double fair = 0, again = 0;
};

// Between what clean and spoiled sweeps of synthetic scenes and of data/photos have (decisions.md).
struct JudgeOptions {
  Bounds smear{0.12, 0.35};            // blur of one axis, more than the other has and than sharp edges
  Bounds dark_noise{3.5, 12};          // noise that even exposure would show [levels]
  Bounds shift{0.47, 0.65};            // from photograph to photograph, in widths
  Bounds usual_shift{0.38, 0.65};      // the same, the median
  Bounds left_out{0.2, 0.6};           // share of the photographs
  Bounds exposure{1.0, 4.0};           // from photograph to photograph, factors of two
  Bounds outward{0.6, 0.7};            // share of the parallax that points away from the middle
  Bounds mismatch{0.28, 0.6};          // photographs' shift against the poses' turns, logarithm
  Bounds unexplained{0.06, 0.25};      // share of the pixels
  Bounds disagreement{0.04, 0.15};     // share of the matches of neighbouring photographs that do not fit the poses
  Bounds reprojection{0.0013, 0.004};  // root mean square, in longer sides
  Bounds holes{0.05, 0.2};             // share of the photographs' pixels
  Bounds expected_db{17, 15.5};        // of new views: below
  double inward = 0.8;                 // correlation, from which a camera went around what it looked at
  double least_parallax = 0.002;       // tangent of an angle, below which a camera only turned
};

SweepQuality judge(const SweepEvidence& evidence, const JudgeOptions& options = {});

// What poses and photographs tell before there is a panorama; nothing is expected yet (0 dB), no direction judged.
SweepQuality judge_sweep(const SweepEvidence& evidence, const JudgeOptions& options = {});

}  // namespace ldp
