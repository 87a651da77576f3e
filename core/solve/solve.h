// The label map of least energy (paper 3.3.1 and 3.3.2), by graph cuts, window by window, in bounded memory.
//
//   E = sum_p phi(p, l_p) + lambda sum_{4-neighbours} min(|l_p - l_q|, truncation) exp(-contrast |g_p - g_q|)
//
// For depth phi is the sweep's cost and g the median grey at the label taken. For colour phi is the angle between
// the pixel's ray and the camera's ray, labels are source frames, and g is the depth label of the pixel (fixed).
// Energy never rises between steps; the same bytes at any thread count. Integer arithmetic throughout.
#pragma once

#include <cstdint>
#include <vector>

#include "colour_costs.h"
#include "cost_source.h"
#include "job.h"
#include "plane.h"

namespace ldp {

struct SolveOptions {
  double lambda = 2;        // in grey levels
  int truncation = 2;       // labels
  double contrast = 0.01;   // per grey level
  int core_px = 96, margin_px = 16;
  size_t memory_bytes = 0;  // costs that may be kept between passes; 0 = recompute
};

struct SolveReport {
  double data_energy = 0, smoothness_energy = 0;  // of the result, in grey levels
  double initial_energy = 0;
  int passes = 0;
  size_t peak_bytes = 0;
};

struct Labelling {
  Plane<uint8_t> labels;
  SolveReport report;
};

// Depth: fixed labels outside `mask` (empty = solve everywhere) are not part of the problem.
Labelling solve_depth(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options, const Job& job);

struct ColourSolveOptions {
  double lambda = 2;
  int truncation = 2;
  double contrast = 0.1;  // per depth label
};

// Gives the source frame of every present pixel (255 where absent or unseen).
Labelling solve_colour(const ColourCosts& costs, const ColourSolveOptions& options, const Job& job);

}  // namespace ldp
