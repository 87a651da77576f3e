#include "windows.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "cuts.h"
#include "framed_window.h"
#include "regions.h"
#include "strip.h"
#include "window_scratch.h"

namespace ldp {

namespace {

constexpr int kColumnsAtOnce = 32;
constexpr int kSmall = 300000;  // pixels; below, one unlucky window shows, and more work costs little
constexpr int kRegionCycles = 4;

size_t at(int i) { return static_cast<size_t>(i); }

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
        small_(source.width() * source.height() < kSmall),
        margin_px_(options.margin_px),
        iterations_(options.iterations),
        settling_iterations_((options.iterations + 1) / 2),
        strip_(source, smoothness),
        started_(static_cast<size_t>(source.width())) {
    result_.slots = Plane<uint8_t>(source.width(), source.height());
    if (source.has_positions()) result_.positions = Plane<uint8_t>(source.width(), source.height());
  }

  void run() {
    if (options_.passes == 0 && !source_.has_positions()) {
      if (small_) {
        settling_iterations_ = options_.iterations;
        iterations_ = options_.iterations * 5 / 2;
        margin_px_ = std::min(options_.margin_px * 3 / 2, (options_.core_px - 2) / 2);
      }
      regions_.emplace(source_.width(), source_.height(), source_.slots(), smoothness_);
      pass(false);
      move_regions();
      return;
    }
    const int passes = options_.passes > 0 ? options_.passes : small_ ? 2 : 1;
    for (int i = 0; i < passes; ++i)
      if (!pass(i % 2 == 1)) break;
  }

  WindowSolve take() {
    note_bytes();
    return std::move(result_);
  }

 private:
  std::vector<Interval> columns(bool shift) const {
    return source_.wraps() ? cut_ring(source_.width(), options_.core_px, margin_px_, shift)
                           : cut_line(source_.width(), options_.core_px, margin_px_, shift);
  }
  std::vector<Interval> rows(bool shift) const {
    return cut_line(source_.height(), even_core(source_.height(), options_.core_px), margin_px_, shift);
  }

  // Windows of a column are solved every second one at a time: their number is a multiple of 4 where there are many,
  // so that two and four threads have the same to do.
  static int even_core(int height, int core_px) {
    const int parts = (height + core_px / 2) / core_px;
    return parts < 3 ? core_px : height / ((parts + 2) / 4 * 4);
  }

  // Solves every window once. True if labels changed.
  bool pass(bool shift) {
    const auto columns = this->columns(shift), rows = this->rows(shift);
    const std::vector<size_t> last = last_interval(columns);
    done_.assign(static_cast<size_t>(source_.width()), false);
    result_.final = {};
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
      finish_columns(last, i);
      job_.report("solve", static_cast<double>(i + 1) / static_cast<double>(columns.size()));
    }
    ++result_.passes;
    return changed;
  }

  // Of every column the last interval that holds it.
  std::vector<size_t> last_interval(const std::vector<Interval>& columns) const {
    std::vector<size_t> last(static_cast<size_t>(source_.width()));
    for (size_t i = 0; i < columns.size(); ++i)
      for (int x = 0; x < columns[i].size; ++x) last[static_cast<size_t>((columns[i].begin + x) % source_.width())] = i;
    return last;
  }

  void plan(const Interval& column) {
    const Window whole = FramedWindow({column.begin, 0, column.size, source_.height()}, source_).outer;
    strip_.plan(whole.x, whole.width);
  }

  // Columns met for the first time start with the labels of least cost.
  void start_columns() {
    std::vector<int> fresh;
    for (int x = 0; x < strip_.width(); ++x)
      if (!started_[at(strip_.column(x))]) fresh.push_back(x);
    for (const int x : fresh) started_[at(strip_.column(x))] = true;
    for_columns(fresh, [&](int x) {
      const std::vector<uint8_t> labels = cheapest_labels(x);
      for (int y = 0; y < source_.height(); ++y)
        set_slot(strip_.column(x), y, x * source_.height() + y, labels[at(y)], strip_.terms());
    });
    result_.initial += energy_of(fresh, started_, [&](int x) { return cheapest_labels(x); });
  }

  // Takes note of the columns that no further window of this pass holds.
  void finish_columns(const std::vector<size_t>& last, size_t interval) {
    std::vector<int> finished;
    for (int x = 0; x < strip_.width(); ++x)
      if (last[at(strip_.column(x))] == interval) finished.push_back(x);
    for (const int x : finished) done_[at(strip_.column(x))] = true;
    result_.final += energy_of(finished, done_, [&](int x) { return current_labels(x); });
    if (!regions_) return;
    for (const int x : finished) regions_->add_column(strip_.terms(), x, strip_.column(x), source_, result_.slots);
    for (const int x : seams_of(finished, done_))
      regions_->add_seam(strip_.terms(), x, strip_.column(x), source_, result_.slots);
  }

  // Columns of the strip after which an edge to the next column begins that exists since some columns were added.
  std::vector<int> seams_of(const std::vector<int>& added, const std::vector<bool>& present) const {
    std::vector<bool> is_added(at(strip_.width()));
    for (const int x : added) is_added[at(x)] = true;
    std::vector<int> seams;
    for (int x = 0; x + 1 < strip_.width(); ++x)
      if ((is_added[at(x)] || is_added[at(x + 1)]) && present[at(strip_.column(x))] &&
          present[at(strip_.column(x + 1))])
        seams.push_back(x);
    return seams;
  }

  template <typename Body>
  void for_columns(const std::vector<int>& columns, const Body& body) const {
    const int count = static_cast<int>(columns.size()), parts = (count + kColumnsAtOnce - 1) / kColumnsAtOnce;
    parallel_for(job_, parts, [&](int i) {
      for (int k = i * kColumnsAtOnce; k < std::min(count, (i + 1) * kColumnsAtOnce); ++k) body(columns[at(k)]);
    });
  }

  // Energy of columns of the strip and of their edges to columns that are present.
  template <typename LabelsOf>
  Energy energy_of(const std::vector<int>& added, const std::vector<bool>& present, const LabelsOf& labels_of) const {
    std::vector<Energy> of_column(at(strip_.width())), of_seam(at(strip_.width()));
    for_columns(added, [&](int x) { of_column[at(x)] = strip_.column_energy(x, labels_of(x)); });
    for_columns(seams_of(added, present),
                [&](int x) { of_seam[at(x)].smoothness = strip_.seam_energy(x, labels_of(x), labels_of(x + 1)); });
    Energy sum;
    for (int x = 0; x < strip_.width(); ++x) {
      sum += of_column[at(x)];
      sum += of_seam[at(x)];
    }
    return sum;
  }

  std::vector<uint8_t> cheapest_labels(int x) const {
    std::vector<uint8_t> labels(at(source_.height()));
    for (int y = 0; y < source_.height(); ++y) labels[at(y)] = cheapest_slot(strip_.terms(), x * source_.height() + y);
    return labels;
  }

  std::vector<uint8_t> current_labels(int x) const {
    std::vector<uint8_t> labels(at(source_.height()));
    for (int y = 0; y < source_.height(); ++y) labels[at(y)] = result_.slots.at(strip_.column(x), y);
    return labels;
  }

  // Solves every second window of the strip, while columns of the next one are loaded.
  bool solve_rows(const Interval& column, const std::vector<Interval>& rows, int parity, bool more) {
    std::vector<Window> windows;
    for (size_t i = static_cast<size_t>(parity); i < rows.size(); i += 2)
      windows.push_back({column.begin, rows[i].begin, column.size, rows[i].size});
    std::vector<uint8_t> changed(windows.size());
    const int solves = static_cast<int>(windows.size()), half = strip_.pieces() / 2;
    const int first_piece = parity == 0 ? 0 : half, pieces = parity == 0 ? half : strip_.pieces() - half;
    parallel_for(job_, solves + (more ? pieces : 0), [&](int i) {
      if (i >= solves) return strip_.load_piece(first_piece + i - solves);
      changed[at(i)] = solve_part(windows[at(i)]);
    });
    return std::any_of(changed.begin(), changed.end(), [](uint8_t one) { return one != 0; });
  }

  // Solves a window that the strip holds.
  bool solve_part(const Window& inner) {
    const FramedWindow window(inner, source_);
    const Window part{0, window.outer.y, window.outer.width, window.outer.height};
    if (!strip_.any_solved(part)) return false;
    auto scratch = pool_.take();
    strip_.copy(part, scratch->grid);
    take_labels(window.outer, result_.slots, scratch->grid);
    fold_ring(window, smoothness_, scratch->grid);
    const bool changed = scratch->solve(smoothness_, source_.slots(), iterations_, options_.cycles, job_);
    if (changed) store_labels(window, scratch->grid);
    pool_.give(std::move(scratch));
    return changed;
  }

  void take_labels(const Window& outer, const Plane<uint8_t>& slots, LabelGrid& grid) const {
    for (int x = 0; x < grid.width; ++x)
      for (int y = 0; y < grid.height; ++y)
        grid.label[at(x * grid.height + y)] = slots.at((outer.x + x) % source_.width(), outer.y + y);
  }

  void store_labels(const FramedWindow& window, const LabelGrid& grid) {
    const Window& inner = window.inner;
    for (int x = 0; x < inner.width; ++x)
      for (int y = 0; y < inner.height; ++y) {
        const int p = (x + window.left_ring) * grid.height + y + window.top_ring;
        set_slot((inner.x + x) % source_.width(), inner.y + y, p, grid.label[at(p)], grid);
      }
  }

  void set_slot(int x, int y, int p, uint8_t slot, const PixelTerms& terms) {
    result_.slots.at(x, y) = slot;
    if (source_.has_positions()) result_.positions.at(x, y) = static_cast<uint8_t>(terms.position_of(p, slot));
  }

  // Moves regions, then solves the windows that this touched, or all; they are loaded one by one.
  void move_regions() {
    note_bytes();
    strip_.clear();
    const Energy start = regions_->energy();
    regions_->move(kRegionCycles, job_);
    const bool settling = options_.settling_cycles > 0;
    if (settling) before_ = result_.slots;
    for (int y = 0; y < source_.height(); ++y)
      for (int x = 0; x < source_.width(); ++x) {
        uint8_t& slot = result_.slots.at(x, y);
        slot = regions_->label_of(x, y, slot);
      }
    if (settling) moved_ = result_.slots;
    note_bytes();
    if (!settling) {
      result_.final += regions_->energy();
      result_.final -= start;
    }
    regions_.reset();
    if (settling) settle();
  }

  void settle() {
    const auto columns = this->columns(true), rows = this->rows(true);
    for (size_t class_x = 0; class_x < 3; ++class_x)
      for (size_t class_y = 0; class_y < 2; ++class_y) {
        std::vector<Cell> cells;
        for (size_t i = 0; i < columns.size(); ++i)
          for (size_t j = class_y; j < rows.size(); j += 2)
            if (class_of(i, columns.size()) == class_x && (small_ || touched(columns[i], rows[j])))
              cells.push_back({columns[i], rows[j]});
        settle(cells);
      }
    ++result_.passes;
  }

  struct Cell {
    Interval column, row;
  };

  // Windows of one class share no edge. On a ring of an odd number of intervals the last is next to the first.
  size_t class_of(size_t interval, size_t count) const {
    return source_.wraps() && count % 2 == 1 && interval + 1 == count ? 2 : interval % 2;
  }

  // Whether a core or the pixels next to it changed.
  bool touched(const Interval& column, const Interval& row) const {
    const int top = std::max(0, row.core_begin - 1),
              bottom = std::min(source_.height(), row.core_begin + row.core_size + 1);
    for (int i = -1; i <= column.core_size; ++i) {
      const int x = column.core_begin + i;
      if (!source_.wraps() && (x < 0 || x >= source_.width())) continue;
      const int wrapped = (x + source_.width()) % source_.width();
      for (int y = top; y < bottom; ++y)
        if (before_.at(wrapped, y) != moved_.at(wrapped, y)) return true;
    }
    return false;
  }

  void settle(const std::vector<Cell>& cells) {
    std::vector<Energy> rises(cells.size());
    parallel_for(job_, static_cast<int>(cells.size()), [&](int i) { rises[at(i)] = settle(cells[at(i)]); });
    for (const Energy& rise : rises) result_.final += rise;
  }

  // Solves a window again. Gives by how much the energy of its core's pixels and edges rose when regions moved, and
  // that of the window since then.
  Energy settle(const Cell& cell) {
    const FramedWindow window({cell.column.begin, cell.row.begin, cell.column.size, cell.row.size}, source_);
    auto scratch = pool_.take();
    LabelGrid& grid = scratch->grid;
    grid.resize(window.outer.width, window.outer.height, false);
    source_.load(window.outer, grid);
    grid.find_grey_ranges();
    set_edges(source_, window.outer, grid);
    take_labels(window.outer, moved_, grid);
    Energy rise = core_energy(cell, window.outer, grid);
    take_labels(window.outer, before_, grid);
    rise -= core_energy(cell, window.outer, grid);
    take_labels(window.outer, result_.slots, grid);
    if (small_ || unsettled(window.outer, grid)) rise += solve_again(window, *scratch);
    pool_.give(std::move(scratch));
    return rise;
  }

  // Whether a label that a region took meets another label in a window.
  bool unsettled(const Window& outer, const LabelGrid& grid) const {
    for (int x = 0; x < grid.width; ++x)
      for (int y = 0; y < grid.height; ++y) {
        const int column = (outer.x + x) % source_.width(), p = x * grid.height + y;
        if (before_.at(column, outer.y + y) == moved_.at(column, outer.y + y)) continue;
        for (int direction = 0; direction < 4; ++direction)
          if (grid.factor(p, direction) != 0 && grid.label[at(p)] != grid.label[at(p + grid.stride(direction))])
            return true;
      }
    return false;
  }

  Energy solve_again(const FramedWindow& window, WindowScratch& scratch) {
    LabelGrid& grid = scratch.grid;
    const auto with_ring = [&](int64_t ring) {  // ring: pair terms that became data terms
      Energy energy = ldp::energy_of(grid, smoothness_);
      energy.data -= ring;
      energy.smoothness += ring;
      return energy;
    };
    const Energy before = with_ring(fold_ring(window, smoothness_, grid));
    if (!scratch.solve(smoothness_, source_.slots(), settling_iterations_, options_.settling_cycles, job_)) return {};
    store_labels(window, grid);
    Energy rise = with_ring(ring_energy(window, source_, smoothness_, grid));
    rise -= before;
    return rise;
  }

  // Energy of the pixels of a core and of the edges that lead down and to the right from them.
  Energy core_energy(const Cell& cell, const Window& outer, const LabelGrid& grid) const {
    const int left = (cell.column.core_begin - outer.x + 2 * source_.width()) % source_.width();
    const int top = cell.row.core_begin - outer.y;
    Energy energy;
    for (int x = left; x < left + cell.column.core_size; ++x)
      for (int y = top; y < top + cell.row.core_size; ++y)
        energy += energy_of_pixel(grid, smoothness_, x * grid.height + y);
    return energy;
  }

  void note_bytes() {
    size_t sum = pool_.bytes() + strip_.bytes() + (regions_ ? regions_->bytes() : 0);
    for (const Plane<uint8_t>* plane : {&result_.slots, &result_.positions, &before_, &moved_})
      sum += plane->samples.capacity();
    result_.peak_bytes = std::max(result_.peak_bytes, sum);
  }

  const GridSource& source_;
  const Smoothness& smoothness_;
  const WindowOptions options_;
  const Job& job_;
  const bool small_;
  int margin_px_;
  int iterations_, settling_iterations_;  // of message passing, in the pass and after regions moved
  Strip strip_;
  std::vector<bool> started_, done_;  // per column: has labels; has the labels of this pass
  ScratchPool pool_;
  std::optional<Regions> regions_;
  Plane<uint8_t> before_, moved_;  // slots before and after regions moved
  WindowSolve result_;
};

}  // namespace

WindowSolve solve_windows(const GridSource& source, const Smoothness& smoothness, const WindowOptions& options,
                          const Job& job) {
  WindowSolver solver(source, smoothness, options, job);
  solver.run();
  return solver.take();
}

}  // namespace ldp
