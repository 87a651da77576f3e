#include "core/solve/window_pass.h"

#include <algorithm>
#include <string>

#include "core/solve/solve_tuning.h"

namespace ldp::solve {

namespace {

bool share_rows(const Interval& rows, const Window& window) {
  return rows.begin < window.y + window.height && window.y < rows.begin + rows.size;
}

}  // namespace

WindowPass::WindowPass(const GridSource& source, const Smoothness& smoothness, const WindowTiling& tiling,
                       const Effort& effort, bool first, SlotMap& slot_map, Regions* regions)
    : source_(source),
      smoothness_(smoothness),
      tiling_(tiling),
      effort_(effort),
      first_(first),
      slot_map_(slot_map),
      regions_(regions),
      buffer_(source, smoothness),
      loads_(tile_line(source.height(), kLoadRows, 0, false)),
      last_place_(at(source.width())),
      changed_(tiling.columns.size() * tiling.rows.size()) {}

void WindowPass::plan_walk() {
  std::vector<Window> places;
  for (size_t i = 0; i < tiling_.columns.size(); ++i) {
    const Interval& column = tiling_.columns[i];
    places.push_back(FramedWindow({column.begin, 0, column.size, source_.height()}, source_).outer);
    for (int x = 0; x < column.size; ++x) last_place_[at((column.begin + x) % source_.width())] = static_cast<int>(i);
  }
  buffer_.plan(places);
}

bool WindowPass::run(const Job& job) {
  job_ = &job;
  plan_walk();
  TaskOrder order;
  std::vector<Task> loads = add_loads(order, 0, {}), windows, finished;  // finished: of the place before, if any
  for (int place = 0; place < static_cast<int>(tiling_.columns.size()); ++place) {
    windows = add_windows(order, place, loads, windows);
    std::vector<Task> complete = windows;
    complete.insert(complete.end(), finished.begin(), finished.end());
    const Task finish = order.add([this, place] { this->finish(place); }, complete);
    loads = add_loads(order, place + 1, finished);
    finished = {finish};
  }
  order.run(job);
  return std::any_of(changed_.begin(), changed_.end(), [](uint8_t one) { return one != 0; });
}

// The piece of a place takes that of the place ColumnBuffer::kHeld before, which all places up to two before have
// finished with. None past the last place.
std::vector<TaskOrder::Task> WindowPass::add_loads(TaskOrder& order, int place, const std::vector<Task>& finished) {
  static_assert(ColumnBuffer::kHeld == 3);
  std::vector<Task> tasks;
  if (at(place) < tiling_.columns.size())
    for (const Interval& rows : loads_) tasks.push_back(order.add([=, this] { load(place, rows); }, finished));
  return tasks;
}

// `before`: the windows of the place before, if any.
std::vector<TaskOrder::Task> WindowPass::add_windows(TaskOrder& order, int place, const std::vector<Task>& loads,
                                                     const std::vector<Task>& before) {
  const size_t count = tiling_.rows.size();
  std::vector<Task> tasks(count);
  for (const size_t parity : {size_t{0}, size_t{1}})
    for (size_t row = parity; row < count; row += 2) {
      const FramedWindow window = this->window(place, row);
      std::vector<Task> waits_for;
      for (size_t i = 0; i < loads.size(); ++i)
        if (share_rows(loads_[i], window.outer)) waits_for.push_back(loads[i]);
      for (size_t beside = row - std::min<size_t>(row, 1); beside < std::min(count, row + 2); ++beside) {
        if (!before.empty()) waits_for.push_back(before[beside]);
        if (parity == 1 && beside != row) waits_for.push_back(tasks[beside]);
      }
      uint8_t& changed = changed_[at(place) * count + row];
      tasks[row] = order.add([=, this, &changed] { changed = solve(place, window); }, waits_for);
    }
  return tasks;
}

FramedWindow WindowPass::window(int place, size_t row) const {
  const Interval &column = tiling_.columns[at(place)], &rows = tiling_.rows[row];
  return {{column.begin, rows.begin, column.size, rows.size}, source_};
}

// Columns met for the first time start with the slots of least cost.
void WindowPass::load(int place, const Interval& rows) {
  buffer_.load_rows(place, rows.begin, rows.size);
  if (!first_) return;
  std::vector<uint8_t> slots(at(rows.size));
  for (int x = buffer_.piece_begin(place); x < std::min(buffer_.end(place), source_.width()); ++x) {
    const int first = buffer_.pixel(x) + rows.begin;
    message_kernels().cheapest(buffer_.terms().costs(first), rows.size, slots.data());
    for (int i = 0; i < rows.size; ++i)
      slot_map_.set(buffer_.column(x), rows.begin + i, slots[at(i)], buffer_.terms(), first + i);
  }
}

// True if slots changed.
bool WindowPass::solve(int place, const FramedWindow& window) {
  const Window part{buffer_.begin(place), window.outer.y, window.outer.width, window.outer.height};
  if (!buffer_.any_solved(part)) return false;
  auto scratch = pool_.take();
  buffer_.copy(part, scratch->grid);
  take_labels(window.outer, slot_map_.slots, scratch->grid);
  fold_ring(window, smoothness_, scratch->grid);
  const bool changed = scratch->solve(smoothness_, source_.slots(), effort_, *job_);
  if (changed) slot_map_.store(window, scratch->grid);
  pool_.give_back(std::move(scratch));
  return changed;
}

// Takes note of the columns that no windows of later places hold.
void WindowPass::finish(int place) {
  final_ += energy_finished(place, [&](int x) { return current(x); });
  if (first_) initial_ += energy_finished(place, [&](int x) { return cheapest(x); });
  if (regions_ != nullptr) {
    const PixelTerms& terms = buffer_.terms();
    for (int x = buffer_.begin(place); x < buffer_.end(place); ++x)
      if (last_place(x) == place)
        regions_->add_column(terms, buffer_.pixel(x), buffer_.column(x), source_, slot_map_.slots);
    for (int x = buffer_.begin(place); x + 1 < buffer_.end(place); ++x)
      if (seam_finished(x, place))
        regions_->add_seam(terms, buffer_.pixel(x), buffer_.pixel(x + 1), buffer_.column(x), source_, slot_map_.slots);
  }
  job_->report("solve", (place + 1.0) / static_cast<double>(tiling_.columns.size()));
}

// Whether the columns on both sides of the seam after a column of a place are finished, and not both before it.
bool WindowPass::seam_finished(int x, int place) const { return std::max(last_place(x), last_place(x + 1)) == place; }

// Energy of the columns that a place finishes and of their edges to columns finished.
template <typename SlotsOf>
Energy WindowPass::energy_finished(int place, const SlotsOf& slots_of) const {
  Energy energy;
  std::vector<uint8_t> before;
  for (int x = buffer_.begin(place); x < buffer_.end(place); ++x) {
    std::vector<uint8_t> slots;
    if (last_place(x) <= place) slots = slots_of(x);  // of others nothing may be read: they are being worked on
    if (last_place(x) == place) energy += buffer_.column_energy(x, slots);
    if (x > buffer_.begin(place) && seam_finished(x - 1, place))
      energy.smoothness += buffer_.seam_energy(x - 1, before, slots);
    before = std::move(slots);
  }
  return energy;
}

std::vector<uint8_t> WindowPass::cheapest(int x) const {
  std::vector<uint8_t> slots(at(source_.height()));
  message_kernels().cheapest(buffer_.terms().costs(buffer_.pixel(x)), source_.height(), slots.data());
  return slots;
}

std::vector<uint8_t> WindowPass::current(int x) const {
  std::vector<uint8_t> slots(at(source_.height()));
  for (int y = 0; y < source_.height(); ++y) slots[at(y)] = slot_map_.slots.at(buffer_.column(x), y);
  return slots;
}

}  // namespace ldp::solve
