#include <utility>

#include "core/solve/depth_problem.h"
#include "core/solve/solve.h"
#include "core/solve/windows.h"

namespace ldp {

using namespace solve;

Labelling solve_depth(const CostSource& costs, const Plane<uint8_t>& mask, const SolveOptions& options,
                      const Job& job) {
  const DepthProblem problem(costs, mask, options);
  WindowSolve solved =
      solve_windows(problem.source(), problem.smoothness(),
                    {options.core_px, options.margin_px, options.iterations, options.cycles, options.passes}, job);
  return {std::move(solved.slot_map.slots), report_of(solved, problem.grey_levels_per_unit())};
}

}  // namespace ldp
