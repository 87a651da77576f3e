#include "core/solve/depth_problem.h"
#include "core/solve/solve.h"
#include "core/solve/windows.h"

namespace ldp {

Labelling solve_depth(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options,
                      const Job& job) {
  const DepthProblem problem(costs, mask, options);
  WindowSolve solve = solve_windows(
      problem.source(), problem.smoothness(),
      {options.core_px, options.margin_px, options.iterations, options.cycles, options.passes, options.settling_cycles},
      job);
  const double grey_levels = problem.grey_levels_per_unit();
  Labelling result;
  result.labels = std::move(solve.taken.slots);
  result.report.data_energy = static_cast<double>(solve.final.data) * grey_levels;
  result.report.smoothness_energy = static_cast<double>(solve.final.smoothness) * grey_levels;
  result.report.initial_energy = static_cast<double>(solve.initial.total()) * grey_levels;
  result.report.passes = solve.passes;
  result.report.peak_bytes = solve.peak_bytes;
  return result;
}

}  // namespace ldp
