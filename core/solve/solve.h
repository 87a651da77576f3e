// The label map of least energy (paper 3.3.1 and 3.3.2), by graph cuts, window by window, in bounded memory.
//
//   E = sum_p phi(p, l_p) + lambda sum_{4-neighbours} min(|l_p - l_q|, truncation) exp(-contrast |g_p - g_q|)
//
// For depth phi is the sweep's cost and g the median grey at the label taken, so that the weight of an edge depends on
// both labels. For colour phi is the angle between the pixel's ray and the camera's ray, labels are source frames, and
// g is the depth label of the pixel (fixed). Energies are sums of integers, in steps fine enough that lambda times
// truncation is about 255 of them; energy never rises between steps, and the bytes are the same at any thread count.
// Does not read images and keeps no volume: it pulls columns from the source once, from left to right.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/cost_source.h"
#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/base/source_costs.h"
#include "core/base/source_map.h"

namespace ldp {

// Multiplies the smoothness weight of single edges: right.at(x, y) that of (x, y)-(x+1, y), down.at(x, y) that of
// (x, y)-(x, y+1); 0 removes the edge. For problems whose weights come from outside, such as stereo benchmarks.
struct EdgeFactors {
  Plane<uint8_t> right, down;
};

// How the defaults were chosen: decisions.md.
struct SolveOptions {
  double lambda = 4;                // in grey levels; lambda * truncation * largest factor <= 62
  int truncation = 4;               // labels, 1 .. 15
  double contrast = 0.01;           // per grey level
  int core_px = 64, margin_px = 8;  // windows: core_px plus margin_px on each side
  int iterations = 4;               // of message passing in each window, at each of four resolutions
  int cycles = 1;                   // of expansion moves over all labels, at most; it ends where nothing moves
  // Over all windows, every second one shifted by half a window. 0: one, then regions of any size move; small grids get
  // more iterations and margin.
  int passes = 0;
  const EdgeFactors* factors = nullptr;  // nullptr: every factor is 1
};

struct SolveReport {
  // Of the result; depth: in grey levels, colour: in degrees. Where regions moved the smoothness energy is an upper
  // bound.
  double data_energy = 0, smoothness_energy = 0;
  double initial_energy = 0;  // of the cheapest label of every pixel
  int passes = 0;
  size_t peak_bytes = 0;  // of all threads
};

struct Labelling {
  Plane<uint8_t> labels;
  SolveReport report;
};

// Depth. Pixels where `mask` is 0 are not part of the problem and get label 0 (empty mask: solve everywhere).
Labelling solve_depth(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options, const Job& job);

struct ColourSolveOptions {
  double lambda = 2;                // in degrees
  int truncation = 2;               // frames
  double contrast = 0.1;            // per depth label
  int core_px = 96, margin_px = 8;  // as for depth
  int iterations = 8;
  int cycles = 20;
  int passes = 0;  // 0: 2 on small grids, else 1
};

struct ColourSolve {
  SourceMap sources;  // kNoSource where absent or unseen
  SolveReport report;
};

// Gives the source frame of every present pixel. Pixels without a candidate have no edges;
// of two candidates whose indices differ by a multiple of 16 only the cheaper is considered.
ColourSolve solve_colour(const ColourCosts& costs, const ColourSolveOptions& options, const Job& job);

}  // namespace ldp
