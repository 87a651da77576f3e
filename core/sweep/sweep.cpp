#include "sweep.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "tables.h"

namespace ldp {
namespace {

constexpr uint8_t kForbiddenCost = 255;

void check_range(const char* name, int value, int low, int high) {
  if (value < low || value > high) {
    throw std::logic_error(std::string("sweep: ") + name + " is " + std::to_string(value) + ", must be " +
                           std::to_string(low) + " to " + std::to_string(high));
  }
}

// Keeps, per ray, the least cost of a label's slabs and the median that goes with it.
class BestOfLabel final : public SlabSink {
 public:
  BestOfLabel(SweepScratch& scratch, int height) : scratch_(scratch), height_(height) {}
  void start(bool first) { first_ = first; }
  void column(int x, const uint16_t* cost, const uint8_t* median) override {
    const size_t at = static_cast<size_t>(x) * static_cast<size_t>(height_);
    kernels::best().keep_best(cost, median, first_, height_, scratch_.best.data() + at,
                              scratch_.best_median.data() + at);
  }

 private:
  SweepScratch& scratch_;
  int height_;
  bool first_ = true;
};

}  // namespace

void Sweep::Tables::labels_seen_twice(int column, int y_begin, std::vector<uint16_t>& labels) const {
  std::fill(labels.begin(), labels.end(), uint16_t{0});
  Lines found;
  for (int label = 0; label < options.labels; ++label) {
    const int y_end = y_begin + static_cast<int>(labels.size());
    lines.find(column, grid.inverse_depth(disparity(label)), y_begin, y_end, found);
    std::vector<int> views(labels.size() + 1, 0);  // as changes from row to row
    for (int k = 0; k < found.count; ++k) {
      ++views[static_cast<size_t>(found.line[static_cast<size_t>(k)].y_begin - y_begin)];
      --views[static_cast<size_t>(found.line[static_cast<size_t>(k)].y_end - y_begin)];
    }
    int seeing = 0;
    for (size_t y = 0; y < labels.size(); ++y) {
      seeing += views[y];
      if (seeing > 1) labels[y] = static_cast<uint16_t>(labels[y] | 1 << label);
    }
  }
}

std::unique_ptr<SweepScratch> Sweep::Tables::take_scratch() {
  const std::lock_guard lock(mutex);
  if (idle.empty()) return std::make_unique<SweepScratch>();
  auto scratch = std::move(idle.back());
  idle.pop_back();
  return scratch;
}

void Sweep::Tables::give_back(std::unique_ptr<SweepScratch> scratch) {
  const std::lock_guard lock(mutex);
  idle.push_back(std::move(scratch));
}

Sweep::Sweep(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid,
             const std::vector<VisibilityMap>& visibility, const DisparityMap& behind, const SweepOptions& options) {
  check_range("labels", options.labels, 2, kLabels);
  check_range("substeps", options.substeps, 1, 16);
  check_range("prior_cost", options.prior_cost, 0, 254);
  check_range("margin", options.margin, 0, 255);
  if (!visibility.empty() && visibility.size() != frames.size())
    throw std::logic_error("sweep: one visibility map per frame is needed");
  if (!behind.empty() && (behind.width != grid.width || behind.height != grid.height)) {
    throw std::logic_error("sweep: the disparity in front must have the grid's size");
  }
  tables_.reset(new Tables{frames,
                           grid,
                           behind.empty() ? nullptr : &behind,
                           options,
                           LineTable(frames, grid, visibility, kHalo),
                           0,
                           {},
                           {}});
  for (const UprightFrame& frame : frames)
    tables_->longest_column = std::max(tables_->longest_column, frame.columns.width);
}

Sweep::~Sweep() = default;
int Sweep::width() const { return tables_->grid.width; }
int Sweep::height() const { return tables_->grid.height; }
int Sweep::labels() const { return tables_->options.labels; }
bool Sweep::wraps() const { return tables_->grid.wraps; }

void Sweep::read(const Window& window, uint8_t* cost, uint8_t* median) const {
  Tables& t = *tables_;
  auto scratch = t.take_scratch();
  const size_t pixels = static_cast<size_t>(window.width) * static_cast<size_t>(window.height);
  const int labels = t.options.labels;
  scratch->slab.reserve(window.height, t.longest_column);
  scratch->best.resize(pixels + kernels::kPadding);
  scratch->best_median.resize(pixels + kernels::kPadding);
  BestOfLabel best(*scratch, window.height);
  for (int label = 0; label < labels; ++label) {
    for (int step = 0; step < t.options.substeps; ++step) {
      best.start(step == 0);
      const double offset = (2.0 * step + 1) / (2.0 * t.options.substeps) - 0.5;
      const double w = t.grid.inverse_depth(t.disparity(std::clamp(label + offset, 0.0, labels - 1.0)));
      sweep_slab(t.lines, w, window, t.options.prior_cost, scratch->slab, best);
    }
    for (size_t i = 0; i < pixels; ++i) {
      cost[i * static_cast<size_t>(labels) + static_cast<size_t>(label)] = scratch->best[i];
      median[i * static_cast<size_t>(labels) + static_cast<size_t>(label)] = scratch->best_median[i];
    }
  }
  t.give_back(std::move(scratch));
  if (t.behind) forbid_front(window, cost);
  rate_unmatched(window, cost);
}

// A label is behind the layers in front only if its whole interval is.
void Sweep::forbid_front(const Window& window, uint8_t* cost) const {
  const Tables& t = *tables_;
  const int labels = t.options.labels;
  for (int x = 0; x < window.width; ++x) {
    const int column = t.grid.wraps ? (window.x + x) % t.grid.width : window.x + x;
    for (int y = 0; y < window.height; ++y, cost += labels) {
      const uint16_t front = t.behind->at(column, window.y + y);
      if (front == kNoDisparity) continue;
      for (int label = 0; label < labels; ++label) {
        if ((2 * label + 1) * kDisparitySteps >= 2 * (labels - 1) * front) cost[label] = kForbiddenCost;
      }
    }
  }
}

// Labels that fewer than two cameras see cannot be matched. Dear, they would draw the surface to where two cameras see,
// along the border of the outermost photo; so they cost little more than the ray's best match, and smoothness decides.
void Sweep::rate_unmatched(const Window& window, uint8_t* cost) const {
  const Tables& t = *tables_;
  const auto labels = static_cast<size_t>(t.options.labels);
  std::vector<uint16_t> matched(static_cast<size_t>(window.height));  // a bit per label
  for (int x = 0; x < window.width; ++x) {
    t.labels_seen_twice(window.x + x, window.y, matched);
    for (const uint16_t seen : matched) {
      int least = t.options.prior_cost;
      for (size_t l = 0; l < labels; ++l)
        if (seen >> l & 1) least = std::min<int>(least, cost[l]);
      const auto most = static_cast<uint8_t>(std::min(least + t.options.margin, t.options.prior_cost));
      for (size_t l = 0; l < labels; ++l)
        if (!(seen >> l & 1) && cost[l] != kForbiddenCost) cost[l] = std::min(cost[l], most);
      cost += labels;
    }
  }
}

}  // namespace ldp
