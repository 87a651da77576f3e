#include "core/solve/windows.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/solve/moves/region_moves.h"
#include "core/solve/solve_tuning.h"
#include "core/solve/tiling.h"
#include "core/solve/window_pass.h"

namespace ldp::solve {

namespace {

class WindowSolver {
 public:
  WindowSolver(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options, const Job& job)
      : source_(source),
        smoothness_(smoothness),
        options_(options),
        job_(job),
        small_(source.width() * source.height() < kSmallPixels),
        margin_px_(options.margin_px),
        result_(source) {}

  WindowSolve run() {
    if (options_.passes == 0 && !source_.has_positions()) {
      pass_and_move_regions();
    } else {
      const int passes = options_.passes > 0 ? options_.passes : small_ ? kSmallPasses : 1;
      for (int i = 0; i < passes; ++i)
        if (!pass(i % 2 == 1, {options_.iterations, options_.cycles})) break;
    }
    note_bytes(0);
    return std::move(result_);
  }

 private:
  WindowTiling tiling(bool shift) const {
    return {source_.wraps() ? tile_ring(source_.width(), options_.core_px, margin_px_, shift)
                            : tile_line(source_.width(), options_.core_px, margin_px_, shift),
            tile_line(source_.height(), even_core(source_.height(), options_.core_px), margin_px_, shift)};
  }

  // Windows of a column are solved every second one at a time: their number is a multiple of 4 where there are many,
  // so that two and four threads have the same to do.
  static int even_core(int height, int core_px) {
    const int parts = (height + core_px / 2) / core_px;
    return parts < 3 ? core_px : height / ((parts + 2) / 4 * 4);
  }

  // Solves every window once. True if labels changed.
  bool pass(bool shift, const Effort& effort) {
    const WindowTiling tiling = this->tiling(shift);
    const bool first = result_.passes == 0;
    WindowPass pass(source_, smoothness_, tiling, effort, first, result_.slot_map, regions_ ? &*regions_ : nullptr);
    const bool changed = pass.run(job_);
    if (first) result_.initial = pass.initial();
    result_.final = pass.final();
    ++result_.passes;
    note_bytes(pass.bytes());
    return changed;
  }

  void pass_and_move_regions() {
    Effort effort{options_.iterations, options_.cycles};
    if (small_) {
      effort.iterations = options_.iterations * kSmallIterations[0] / kSmallIterations[1];
      margin_px_ = std::min(options_.margin_px * kSmallMargin[0] / kSmallMargin[1], (options_.core_px - 2) / 2);
    }
    regions_.emplace(source_.width(), source_.height(), source_.slots(), smoothness_);
    pass(false, effort);
    const Energy start = regions_->energy();
    const Energy end = move_regions();
    result_.final -= start;
    result_.final += end;
  }

  // Gives the energy of regions then.
  Energy move_regions() {
    regions_->move(kRegionCycles, job_);
    for (int y = 0; y < source_.height(); ++y)
      for (int x = 0; x < source_.width(); ++x) {
        uint8_t& slot = result_.slot_map.slots.at(x, y);
        slot = regions_->label_of(x, y, slot);
      }
    note_bytes(0);
    const Energy energy = regions_->energy();
    regions_.reset();
    return energy;
  }

  void note_bytes(size_t of_step) {
    const size_t sum = of_step + (regions_ ? regions_->bytes() : 0) + result_.slot_map.slots.samples.capacity() +
                       result_.slot_map.positions.samples.capacity();
    result_.peak_bytes = std::max(result_.peak_bytes, sum);
  }

  const GridSource& source_;
  const Smoothness& smoothness_;
  const WindowOptions options_;
  const Job& job_;
  const bool small_;
  int margin_px_;
  std::optional<Regions> regions_;
  WindowSolve result_;
};

}  // namespace

SolveReport report_of(const WindowSolve& solve, double per_unit) {
  SolveReport report;
  report.data_energy = static_cast<double>(solve.final.data) * per_unit;
  report.smoothness_energy = static_cast<double>(solve.final.smoothness) * per_unit;
  report.initial_energy = static_cast<double>(solve.initial.total()) * per_unit;
  report.passes = solve.passes;
  report.peak_bytes = solve.peak_bytes;
  return report;
}

WindowSolve solve_windows(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options,
                          const Job& job) {
  return WindowSolver(source, smoothness, options, job).run();
}

}  // namespace ldp::solve
