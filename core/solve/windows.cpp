#include "windows.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "expansion.h"

namespace ldp {

namespace {

constexpr int kStripColumns = 32;
constexpr int kCoarseLevels = 3;
constexpr int kMaxCycles = 20;  // of expansion over all slots; mostly 3 or 4 are enough
constexpr int kSmall = 300000;  // pixels; below, one unlucky window shows, and a second, shifted pass costs little

// What a thread needs to work on one window; kept for the next window.
struct Scratch {
  LabelGrid grid;
  std::array<LabelGrid, kCoarseLevels> coarse;  // the window at 1/2, 1/4 ... of its resolution
  Expansion expansion;
  std::vector<uint8_t> labels;

  size_t bytes() const {
    size_t sum = labels.capacity() + grid.bytes();
    for (const LabelGrid& level : coarse) sum += level.bytes();
    return sum + expansion.bytes();
  }
};

class ScratchPool {
 public:
  std::unique_ptr<Scratch> take() {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) return std::make_unique<Scratch>();
    auto scratch = std::move(free_.back());
    free_.pop_back();
    return scratch;
  }
  void give(std::unique_ptr<Scratch> scratch) {
    const std::scoped_lock lock(mutex_);
    free_.push_back(std::move(scratch));
  }
  size_t bytes() const {
    size_t sum = 0;
    for (const auto& scratch : free_) sum += scratch->bytes();
    return sum;
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> free_;
};

// Intervals that cut a length into parts of about core_px, each widened by the margin; `shift` moves the cuts by half
// a part. Group g holds every interval i with group[i] == g; intervals of a group are at least 2 pixels apart.
struct Cuts {
  struct Interval {
    int begin, size, group;
  };
  std::vector<Interval> intervals;
  int groups = 0;
};

Cuts cut_line(int length, int core_px, int margin_px, bool shift) {
  Cuts cuts;
  const int parts = std::max(1, (length + core_px / 2) / core_px) + (shift ? 1 : 0);
  for (int i = 0; i < parts; ++i) {
    const auto edge = [&](int k) {
      const double position = shift ? k - 0.5 : k;
      const int cells = shift ? parts - 1 : parts;
      return std::clamp(static_cast<int>(position * length / cells), 0, length);
    };
    const int begin = std::max(0, edge(i) - margin_px), end = std::min(length, edge(i + 1) + margin_px);
    if (end > begin) cuts.intervals.push_back({begin, end - begin, i % 2});
  }
  cuts.groups = std::min<int>(2, parts);
  return cuts;
}

Cuts cut_ring(int length, int core_px, int margin_px, bool shift) {
  Cuts cuts;
  const int parts = std::max(2, (length + core_px / 2) / core_px);
  for (int i = 0; i < parts; ++i) {
    const int64_t half = shift ? length / (2 * parts) : 0;
    const int begin = static_cast<int>(static_cast<int64_t>(i) * length / parts + half) - margin_px;
    const int end = static_cast<int>((static_cast<int64_t>(i) + 1) * length / parts + half) + margin_px;
    const int group = parts % 2 == 1 && i == parts - 1 ? 2 : i % 2;
    cuts.intervals.push_back({((begin % length) + length) % length, std::min(end - begin, length - 1), group});
  }
  cuts.groups = parts % 2 == 1 ? 3 : 2;
  return cuts;
}

int wrapped(int x, int width) { return x >= width ? x - width : x; }

// A window loaded with a ring of fixed pixels around it, where the grid goes on.
struct FramedWindow {
  Window inner, outer;

  FramedWindow(const Window& window, const GridSource& source) : inner(window), outer(window) {
    const bool left = source.wraps() || window.x > 0;
    const bool right = source.wraps() || window.x + window.width < source.width();
    const bool top = window.y > 0, bottom = window.y + window.height < source.height();
    outer.x += left ? (window.x == 0 ? source.width() : 0) - 1 : 0;
    outer.y -= top ? 1 : 0;
    outer.width += (left ? 1 : 0) + (right ? 1 : 0);
    outer.height += (top ? 1 : 0) + (bottom ? 1 : 0);
    left_ring = left ? 1 : 0;
    top_ring = top ? 1 : 0;
  }
  bool inside(int x, int y) const {
    return x >= left_ring && y >= top_ring && x < left_ring + inner.width && y < top_ring + inner.height;
  }

  int left_ring = 0, top_ring = 0;
};

void load_labels(const Window& window, const Plane<uint8_t>& slots, LabelGrid& grid) {
  for (int x = 0; x < window.width; ++x)
    for (int y = 0; y < window.height; ++y)
      grid.label[static_cast<size_t>(x * window.height + y)] =
          slots.at(wrapped(window.x + x, slots.width), window.y + y);
}

// Turns edges to the fixed pixels of the ring into unary costs and removes them; the ring itself has nothing to choose.
void fold_ring(const FramedWindow& window, const Smoothness& smoothness, LabelGrid& grid) {
  const auto fold = [&](int p, int q, bool p_inside, int factor) {
    const int moving = p_inside ? p : q, fixed = p_inside ? q : p;
    const int label = grid.label[static_cast<size_t>(fixed)];
    uint16_t* cost = grid.cost.data() + static_cast<ptrdiff_t>(moving) * kSlots;
    for (int slot = 0; slot < kSlots; ++slot)
      cost[slot] = static_cast<uint16_t>(cost[slot] + grid.pair(smoothness, factor, moving, slot, fixed, label));
  };
  for (int x = 0; x < grid.width; ++x)
    for (int y = 0; y < grid.height; ++y) {
      const int p = x * grid.height + y;
      const bool inside = window.inside(x, y);
      if (!inside) std::fill_n(grid.cost.begin() + static_cast<ptrdiff_t>(p) * kSlots, kSlots, uint16_t{0});
      for (const bool vertical : {true, false}) {
        const bool other_inside = vertical ? window.inside(x, y + 1) : window.inside(x + 1, y);
        if (inside && other_inside) continue;
        uint8_t& factor = vertical ? grid.down[static_cast<size_t>(p)] : grid.right[static_cast<size_t>(p)];
        if (factor != 0 && inside != other_inside) fold(p, p + (vertical ? 1 : grid.height), inside, factor);
        factor = 0;
      }
    }
}

// Everything that the solve of one problem shares between its windows.
class WindowSolver {
 public:
  WindowSolver(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options, const Job& job)
      : source_(source),
        smoothness_(smoothness),
        options_(options),
        job_(job),
        slots_(source.width(), source.height()) {}

  // Labels of least cost, or the energy of the labels given, or both, strip by strip.
  Energy scan(bool choose) {
    const int strips = (source_.width() + kStripColumns - 1) / kStripColumns;
    std::vector<Energy> energies(static_cast<size_t>(strips));
    parallel_for(job_, strips, [&](int i) { energies[static_cast<size_t>(i)] = scan_strip(i, choose); });
    Energy sum;
    for (const Energy& energy : energies) {
      sum.data += energy.data;
      sum.smoothness += energy.smoothness;
    }
    return sum;
  }

  bool pass(bool shift) {
    const int core_px = options_.core_px, margin_px = options_.margin_px;
    const Cuts columns = source_.wraps() ? cut_ring(source_.width(), core_px, margin_px, shift)
                                         : cut_line(source_.width(), core_px, margin_px, shift);
    const Cuts rows = cut_line(source_.height(), core_px, margin_px, shift);
    std::atomic<bool> changed = false;
    for (int colour = 0; colour < columns.groups * rows.groups; ++colour) {
      std::vector<Window> windows;
      for (const auto& column : columns.intervals)
        for (const auto& row : rows.intervals)
          if (column.group + columns.groups * row.group == colour)
            windows.push_back({column.begin, row.begin, column.size, row.size});
      parallel_for(job_, static_cast<int>(windows.size()), [&](int i) {
        if (solve(windows[static_cast<size_t>(i)])) changed = true;
      });
    }
    return changed;
  }

  Plane<uint8_t>& slots() { return slots_; }
  size_t bytes() const { return pool_.bytes() + slots_.samples.capacity(); }

 private:
  Energy scan_strip(int strip, bool choose) {
    const int begin = strip * kStripColumns, end = std::min(source_.width(), begin + kStripColumns);
    const bool next = end < source_.width() || source_.wraps();
    const Window window{begin, 0, end - begin + (next ? 1 : 0), source_.height()};
    auto scratch = pool_.take();
    LabelGrid& grid = scratch->grid;
    source_.load(window, grid);
    if (choose) {
      for (int p = 0; p < grid.size(); ++p)
        grid.label[static_cast<size_t>(p)] =
            static_cast<uint8_t>(std::min_element(grid.costs(p), grid.costs(p) + kSlots) - grid.costs(p));
    } else {
      load_labels(window, slots_, grid);
    }
    if (next) {  // the last column belongs to the next strip
      const int last = (end - begin) * grid.height;
      std::fill(grid.cost.begin() + last * kSlots, grid.cost.end(), uint16_t{0});
      std::fill(grid.down.begin() + last, grid.down.end(), uint8_t{0});
    }
    const Energy energy = energy_of(grid, smoothness_);
    if (choose) store_labels({begin, 0, end - begin, source_.height()}, 0, 0, grid);
    pool_.give(std::move(scratch));
    return energy;
  }

  bool solve(const Window& inner) {
    auto scratch = pool_.take();
    LabelGrid& grid = scratch->grid;
    const FramedWindow window(inner, source_);
    source_.load(window.outer, grid);
    load_labels(window.outer, slots_, grid);
    fold_ring(window, smoothness_, grid);
    bool changed = pass_messages(*scratch);
    scratch->expansion.start(grid, smoothness_);
    for (int cycle = 0; cycle < kMaxCycles; ++cycle) {
      bool pending = false;
      for (int alpha = 0; alpha < source_.slots(); ++alpha) {
        job_.check();
        if (!scratch->expansion.pending(alpha)) continue;
        pending = true;
        if (scratch->expansion.expand(alpha)) changed = true;
      }
      if (!pending) break;
    }
    if (changed) store_labels(inner, window.left_ring, window.top_ring, grid);
    pool_.give(std::move(scratch));
    return changed;
  }

  // Message passing leaves its reparametrisation in the grid; its labels are taken if they are no worse.
  bool pass_messages(Scratch& scratch) {
    LabelGrid& grid = scratch.grid;
    const int64_t energy = energy_of(grid, smoothness_).total();
    scratch.labels = grid.label;
    const LabelGrid* finer = &grid;
    for (LabelGrid& level : scratch.coarse) {
      coarsen(*finer, level);
      finer = &level;
    }
    for (int i = kCoarseLevels; i-- > 0;) {
      exchange(scratch.coarse[static_cast<size_t>(i)], options_.iterations);
      spread_messages(scratch.coarse[static_cast<size_t>(i)],
                      i == 0 ? grid : scratch.coarse[static_cast<size_t>(i - 1)]);
    }
    exchange(grid, (3 * options_.iterations + 3) / 4);  // the coarse start saves a quarter of them
    message_kernels().decide(grid.kernel_grid(smoothness_));
    if (energy_of(grid, smoothness_).total() < energy) return true;
    grid.label = scratch.labels;
    return false;
  }

  void exchange(LabelGrid& grid, int iterations) {
    const KernelGrid kernel_grid = grid.kernel_grid(smoothness_);
    for (int i = 0; i < iterations; ++i) {
      job_.check();
      message_kernels().sweep(kernel_grid, true, 0, grid.width);
      message_kernels().sweep(kernel_grid, false, 0, grid.width);
    }
  }

  void store_labels(const Window& window, int left, int top, const LabelGrid& grid) {
    for (int x = 0; x < window.width; ++x)
      for (int y = 0; y < window.height; ++y)
        slots_.at(wrapped(window.x + x, slots_.width), window.y + y) =
            grid.label[static_cast<size_t>((x + left) * grid.height + y + top)];
  }

  const GridSource& source_;
  const Smoothness& smoothness_;
  const WindowOptions options_;
  const Job& job_;
  Plane<uint8_t> slots_;
  ScratchPool pool_;
};

}  // namespace

WindowSolve solve_windows(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options,
                          const Job& job) {
  WindowSolver solver(source, smoothness, options, job);
  WindowSolve result;
  result.initial = solver.scan(true);
  const int passes = options.passes > 0 ? options.passes : source.width() * source.height() < kSmall ? 2 : 1;
  while (result.passes < passes) {
    job.report("solve", static_cast<double>(result.passes) / passes);
    const bool changed = solver.pass(result.passes % 2 == 1);
    ++result.passes;
    if (!changed) break;
  }
  result.final = solver.scan(false);
  result.peak_bytes = solver.bytes();
  result.slots = std::move(solver.slots());
  return result;
}

Energy energy_of(const GridSource& source, const Smoothness& smoothness, const Plane<uint8_t>& slots, const Job& job) {
  WindowSolver solver(source, smoothness, {}, job);
  solver.slots() = slots;
  return solver.scan(false);
}

}  // namespace ldp
