// Solves every window of a problem once: each window's labels are improved with everything outside it held fixed, so
// that the energy of the whole never rises. Windows form columns, and those of a column hold each its place on the way
// of the buffer. A window waits for its neighbours in the column before, and every second one for those above and below
// it; this order alone, not timing, decides what a window sees of others. Columns further on are loaded meanwhile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/base/scratch_pool.h"
#include "core/base/task_order.h"
#include "core/solve/column_buffer.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/region_moves.h"
#include "core/solve/moves/slot_map.h"
#include "core/solve/moves/smoothness.h"
#include "core/solve/tiling.h"
#include "core/solve/window_scratch.h"

namespace ldp::solve {

class WindowPass {
 public:
  // On the first pass pixels start with the slots of least cost, later with those taken. `regions`, unless nullptr, is
  // given all columns as the pass leaves them.
  WindowPass(const GridSource& source, const Smoothness& smoothness, const WindowTiling& tiling, const Effort& effort,
             bool first, SlotMap& slot_map, Regions* regions);

  // True if slots changed.
  bool run(const Job& job);

  const Energy& initial() const { return initial_; }  // of the slots of least cost; of the first pass only
  const Energy& final() const { return final_; }
  size_t bytes() const { return buffer_.bytes() + pool_.bytes(); }

 private:
  using Task = TaskOrder::Task;

  void plan_walk();
  std::vector<Task> add_loads(TaskOrder& order, int place, const std::vector<Task>& finished);
  std::vector<Task> add_windows(TaskOrder& order, int place, const std::vector<Task>& loads,
                                const std::vector<Task>& before);
  FramedWindow window(int place, size_t row) const;
  void load(int place, const Interval& rows);
  bool solve(int place, const FramedWindow& window);
  void finish(int place);
  int last_place(int x) const { return last_place_[static_cast<size_t>(buffer_.column(x))]; }
  bool seam_finished(int x, int place) const;
  template <typename SlotsOf>
  Energy energy_finished(int place, const SlotsOf& slots_of) const;
  std::vector<uint8_t> cheapest(int x) const;
  std::vector<uint8_t> current(int x) const;

  const GridSource& source_;
  const Smoothness& smoothness_;
  const WindowTiling& tiling_;
  const Effort effort_;
  const bool first_;
  SlotMap& slot_map_;
  Regions* regions_;
  const Job* job_ = nullptr;
  ColumnBuffer buffer_;
  ScratchPool<WindowScratch> pool_;
  std::vector<Interval> loads_;   // of rows
  std::vector<int> last_place_;   // of every column of the source, the last whose windows hold it
  std::vector<uint8_t> changed_;  // per window
  Energy initial_, final_;
};

}  // namespace ldp::solve
