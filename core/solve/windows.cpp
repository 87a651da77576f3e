#include "windows.h"

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "cuts.h"
#include "expansion.h"
#include "strip.h"

namespace ldp {

namespace {

constexpr int kCoarseLevels = 3;
constexpr int kColumnsAtOnce = 32;
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

uint8_t cheapest_slot(const PixelTerms& terms, int p) {
  return static_cast<uint8_t>(std::min_element(terms.costs(p), terms.costs(p) + kSlots) - terms.costs(p));
}

// Everything that the solve of one problem shares between its windows.
class WindowSolver {
 public:
  WindowSolver(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options, const Job& job)
      : source_(source),
        smoothness_(smoothness),
        options_(options),
        job_(job),
        strip_(source, smoothness),
        started_(static_cast<size_t>(source.width())) {
    result_.slots = Plane<uint8_t>(source.width(), source.height());
    if (source.has_positions()) result_.positions = Plane<uint8_t>(source.width(), source.height());
  }

  // Solves every window once. True if labels changed.
  bool pass(bool shift) {
    const int core_px = options_.core_px, margin_px = options_.margin_px;
    const auto columns = source_.wraps() ? cut_ring(source_.width(), core_px, margin_px, shift)
                                         : cut_line(source_.width(), core_px, margin_px, shift);
    const auto rows = cut_line(source_.height(), even_core(source_.height(), core_px), margin_px, shift);
    bool changed = false;
    plan(columns[0]);
    parallel_for(job_, strip_.pieces(), [&](int i) { strip_.load_piece(i); });
    for (size_t i = 0; i < columns.size(); ++i) {
      strip_.move();
      start_columns();
      const bool more = i + 1 < columns.size();
      if (more) plan(columns[i + 1]);
      for (int parity = 0; parity < 2; ++parity)
        if (solve_rows(columns[i], rows, parity, more)) changed = true;
      job_.report("solve", static_cast<double>(i + 1) / static_cast<double>(columns.size()));
    }
    ++result_.passes;
    return changed;
  }

  WindowSolve take() {
    result_.peak_bytes =
        pool_.bytes() + strip_.bytes() + result_.slots.samples.capacity() + result_.positions.samples.capacity();
    return std::move(result_);
  }

 private:
  struct Outcome {
    bool changed = false;
    Energy before, after;
  };

  // Windows of a column are solved every second one at a time: their number is a multiple of 4 where there are many,
  // so that two and four threads have the same to do.
  static int even_core(int height, int core_px) {
    const int parts = (height + core_px / 2) / core_px;
    return parts < 3 ? core_px : height / ((parts + 2) / 4 * 4);
  }

  void plan(const Interval& column) {
    const Window whole = FramedWindow({column.begin, 0, column.size, source_.height()}, source_).outer;
    strip_.plan(whole.x, whole.width);
  }

  // Columns met for the first time start with the labels of least cost.
  void start_columns() {
    const int width = strip_.width();
    for (int x = 0; x < width;) {
      int end = x;
      while (end < width && !started_[static_cast<size_t>(strip_.column(end))])
        started_[static_cast<size_t>(strip_.column(end++))] = true;
      if (end == x) {
        ++x;
        continue;
      }
      start_run(x, end);
      x = end;
    }
  }

  void start_run(int first, int end) {
    const int height = source_.height(), parts = (end - first + kColumnsAtOnce - 1) / kColumnsAtOnce;
    std::vector<Energy> energies(static_cast<size_t>(parts));
    parallel_for(job_, parts, [&](int i) {
      const int begin = first + i * kColumnsAtOnce, count = std::min(kColumnsAtOnce, end - begin);
      const std::vector<uint8_t> labels = cheapest_labels(begin, count);
      for (int p = 0; p < count * height; ++p)
        set_slot(strip_.column(begin + p / height), p % height, begin * height + p, labels[static_cast<size_t>(p)],
                 strip_.terms());
      energies[static_cast<size_t>(i)] = strip_.energy({begin, 0, count, height}, labels.data());
    });
    for (int i = 0; i < parts; ++i) {
      result_.initial += energies[static_cast<size_t>(i)];
      result_.final += energies[static_cast<size_t>(i)];
      add_seam(first + i * kColumnsAtOnce);
    }
    add_seam(end);
  }

  std::vector<uint8_t> cheapest_labels(int x, int count) const {
    std::vector<uint8_t> labels;
    for (int p = x * source_.height(); p < (x + count) * source_.height(); ++p)
      labels.push_back(cheapest_slot(strip_.terms(), p));
    return labels;
  }

  std::vector<uint8_t> current_labels(int x, int count) const {
    std::vector<uint8_t> labels;
    for (int i = x; i < x + count; ++i)
      for (int y = 0; y < source_.height(); ++y) labels.push_back(result_.slots.at(strip_.column(i), y));
    return labels;
  }

  // Adds the energy of the edges between columns x - 1 and x of the strip.
  void add_seam(int x) {
    if (x == 0 || x == strip_.width()) return;
    const int height = source_.height();
    const auto seam = [&](const std::vector<uint8_t>& labels) {
      Energy energy = strip_.energy({x - 1, 0, 2, height}, labels.data());
      energy -= strip_.energy({x - 1, 0, 1, height}, labels.data());
      energy -= strip_.energy({x, 0, 1, height}, labels.data() + height);
      return energy;
    };
    result_.initial += seam(cheapest_labels(x - 1, 2));
    result_.final += seam(current_labels(x - 1, 2));
  }

  // Solves every second window of the strip, while columns of the next one are loaded.
  bool solve_rows(const Interval& column, const std::vector<Interval>& rows, int parity, bool more) {
    std::vector<Window> windows;
    for (size_t i = static_cast<size_t>(parity); i < rows.size(); i += 2)
      windows.push_back({column.begin, rows[i].begin, column.size, rows[i].size});
    std::vector<Outcome> outcomes(windows.size());
    const int solves = static_cast<int>(windows.size()), half = strip_.pieces() / 2;
    const int first_piece = parity == 0 ? 0 : half, pieces = parity == 0 ? half : strip_.pieces() - half;
    parallel_for(job_, solves + (more ? pieces : 0), [&](int i) {
      if (i >= solves) return strip_.load_piece(first_piece + i - solves);
      const auto index = static_cast<size_t>(i);
      outcomes[index] = solve(windows[index]);
    });
    bool changed = false;
    for (const Outcome& outcome : outcomes) {
      if (!outcome.changed) continue;
      changed = true;
      result_.final += outcome.after;
      result_.final -= outcome.before;
    }
    return changed;
  }

  Outcome solve(const Window& inner) {
    const FramedWindow window(inner, source_);
    const Window part{0, window.outer.y, window.outer.width, window.outer.height};
    if (!strip_.any_solved(part)) return {};
    auto scratch = pool_.take();
    LabelGrid& grid = scratch->grid;
    strip_.copy(part, grid);
    for (int x = 0; x < part.width; ++x)
      for (int y = 0; y < part.height; ++y)
        grid.label[static_cast<size_t>(x * part.height + y)] = result_.slots.at(strip_.column(x), part.y + y);
    Outcome outcome;
    outcome.before = strip_.energy(part, grid.label.data());
    fold_ring(window, smoothness_, grid);
    outcome.changed = pass_messages(*scratch);
    if (expand(*scratch)) outcome.changed = true;
    if (outcome.changed) {
      outcome.after = strip_.energy(part, grid.label.data());
      store_labels(window, grid);
    }
    pool_.give(std::move(scratch));
    return outcome;
  }

  bool expand(Scratch& scratch) {
    if (options_.cycles == 0) return false;
    bool changed = false;
    scratch.expansion.start(scratch.grid, smoothness_);
    for (int cycle = 0; cycle < options_.cycles; ++cycle) {
      bool pending = false;
      for (int alpha = 0; alpha < source_.slots(); ++alpha) {
        job_.check();
        if (!scratch.expansion.pending(alpha)) continue;
        pending = true;
        if (scratch.expansion.expand(alpha)) changed = true;
      }
      if (!pending) break;
    }
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

  void store_labels(const FramedWindow& window, const LabelGrid& grid) {
    const Window& inner = window.inner;
    for (int x = 0; x < inner.width; ++x)
      for (int y = 0; y < inner.height; ++y) {
        const int p = (x + window.left_ring) * grid.height + y + window.top_ring;
        set_slot(strip_.column(x + window.left_ring), inner.y + y, p, grid.label[static_cast<size_t>(p)], grid);
      }
  }

  void set_slot(int x, int y, int p, uint8_t slot, const PixelTerms& terms) {
    result_.slots.at(x, y) = slot;
    if (source_.has_positions()) result_.positions.at(x, y) = static_cast<uint8_t>(terms.position_of(p, slot));
  }

  const GridSource& source_;
  const Smoothness& smoothness_;
  const WindowOptions options_;
  const Job& job_;
  Strip strip_;
  std::vector<bool> started_;  // per column: has labels
  ScratchPool pool_;
  WindowSolve result_;
};

}  // namespace

WindowSolve solve_windows(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options,
                          const Job& job) {
  WindowSolver solver(source, smoothness, options, job);
  const int passes = options.passes > 0 ? options.passes : source.width() * source.height() < kSmall ? 2 : 1;
  for (int i = 0; i < passes; ++i)
    if (!solver.pass(i % 2 == 1)) break;
  return solver.take();
}

}  // namespace ldp
