#include "core/sweep/cost_volume.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "core/sweep/cost_volume_tables.h"
#include "core/sweep/sweep_tuning.h"

namespace ldp::sweep {
namespace {

constexpr uint8_t kForbiddenCost = 255, kMiddleGrey = 128;

using namespace tuning;

void check_range(const char* name, int value, int low, int high) {
  if (value < low || value > high) {
    throw std::logic_error(std::string("sweep: ") + name + " is " + std::to_string(value) + ", must be " +
                           std::to_string(low) + " to " + std::to_string(high));
  }
}

// Keeps, per ray, the least cost of a label's slabs, the median that goes with it, and the contrast where one is
// expected.
class BestOfLabel final : public SlabSink {
 public:
  BestOfLabel(SweepScratch& scratch, const Window& window, const Window& part)
      : scratch_(scratch),
        height_(window.height),
        part_{part.x - window.x, part.y - window.y, part.width, part.height} {}
  void start(bool first) { first_ = first; }
  void column(int x, const uint16_t* cost, const uint8_t* median, const uint8_t* contrast) override {
    const auto at = static_cast<size_t>((part_.x + x) * height_ + part_.y);
    kernels::best().keep_best(cost, median, first_, part_.height, scratch_.best.data() + at,
                              scratch_.best_median.data() + at);
    if (contrast) std::copy(contrast, contrast + part_.height, scratch_.contrast.data() + at);
  }

 private:
  SweepScratch& scratch_;
  int height_;
  Window part_;  // from the window's corner
  bool first_ = true;
};

// Of the pixels of a column that may take the label. Without branches, for vectors.
void keep_least(const int8_t* farthest, int label, int count, size_t at, SweepScratch& scratch) {
  const uint8_t *cost = scratch.best.data() + at, *contrast = scratch.contrast.data() + at;
  uint8_t *least = scratch.least.data() + at, *contrast_at_least = scratch.contrast_at_least.data() + at;
  const auto own = static_cast<int8_t>(label);
  for (int i = 0; i < count; ++i) {
    const bool allowed = farthest == nullptr || farthest[i] >= own, better = allowed & (cost[i] < least[i]);
    contrast_at_least[i] = better ? contrast[i] : contrast_at_least[i];
    least[i] = better ? cost[i] : least[i];
  }
}

}  // namespace
}  // namespace ldp::sweep

namespace ldp {

using namespace sweep;

void CostVolume::Tables::labels_seen_twice(int column, int y_begin, std::vector<uint16_t>& labels) const {
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

CostVolume::CostVolume(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid,
                       const std::vector<VisibilityMap>& visibility, const DisparityMap& behind,
                       const SweepOptions& options) {
  check_range("labels", options.labels, 2, kLabels);
  check_range("substeps", options.substeps, 1, 16);
  check_range("prior_cost", options.prior_cost, 0, 254);
  check_range("margin", options.margin, 0, 255);
  if (!visibility.empty() && visibility.size() != frames.size())
    throw std::logic_error("sweep: one visibility map per frame is needed");
  if (!behind.empty() && (behind.width != grid.width || behind.height != grid.height)) {
    throw std::logic_error("sweep: the disparity in front must have the grid's size");
  }
  tables_.reset(new Tables{
      frames,
      grid,
      behind.empty() ? nullptr : &behind,
      options,
      LineTable(frames, grid, visibility, kHalo, behind.empty() ? LineTable::Layer::front : LineTable::Layer::behind),
      {},
      0,
      {}});
  if (options.points && behind.empty()) tables_->points.emplace(grid, *options.points, options.labels);
  tables_->options.points = nullptr;
  for (const UprightFrame& frame : frames)
    tables_->longest_column = std::max(tables_->longest_column, frame.columns.width);
}

CostVolume::~CostVolume() = default;
int CostVolume::width() const { return tables_->grid.width; }
int CostVolume::height() const { return tables_->grid.height; }
int CostVolume::labels() const { return tables_->options.labels; }
bool CostVolume::wraps() const { return tables_->grid.wraps; }

void CostVolume::read(const Window& window, uint8_t* cost, uint8_t* median) const {
  Tables& t = *tables_;
  auto scratch = t.pool.take();
  const size_t pixels = static_cast<size_t>(window.width) * static_cast<size_t>(window.height);
  const int labels = t.options.labels;
  scratch->slab.reserve(window.height, t.longest_column);
  scratch->best.resize(pixels + kernels::kPadding);
  scratch->best_median.resize(pixels + kernels::kPadding);
  scratch->contrast.resize(pixels);
  scratch->least.assign(pixels, kForbiddenCost);
  scratch->contrast_at_least.assign(pixels, kForbiddenCost);
  const std::vector<int8_t> farthest = t.behind ? labels_behind(window) : std::vector<int8_t>();
  for (int label = 0; label < labels; ++label) {
    const Window part = t.behind ? part_with_label(window, farthest, label) : window;
    if (part.width == 0) continue;
    BestOfLabel best(*scratch, window, part);
    for (int step = 0; step < t.options.substeps; ++step) {
      best.start(step == 0);
      const double offset = (2.0 * step + 1) / (2.0 * t.options.substeps) - 0.5;
      const double w = t.grid.inverse_depth(t.disparity(std::clamp(label + offset, 0.0, labels - 1.0)));
      const bool middle = step == t.options.substeps / 2;
      sweep_slab(t.lines, w, part, t.options.prior_cost, middle, scratch->slab, best);
    }
    for (int x = part.x - window.x; x < part.x - window.x + part.width; ++x)
      for (int y = part.y - window.y; y < part.y - window.y + part.height; ++y) {
        const auto i = static_cast<size_t>(x * window.height + y);
        cost[i * static_cast<size_t>(labels) + static_cast<size_t>(label)] = scratch->best[i];
        median[i * static_cast<size_t>(labels) + static_cast<size_t>(label)] = scratch->best_median[i];
      }
    for (int x = part.x - window.x; x < part.x - window.x + part.width; ++x) {
      const auto at = static_cast<size_t>(x * window.height + part.y - window.y);
      keep_least(t.behind ? farthest.data() + at : nullptr, label, part.height, at, *scratch);
    }
  }
  if (t.behind) forbid_front(farthest, cost, median);
  rate_unmatched(window, cost);
  equal_where_plain(*scratch, pixels, cost);
  if (t.points) draw_to_points(*scratch, window, cost);
  t.pool.give_back(std::move(scratch));
}

// The nearest label whose whole interval lies behind the layers in front, for every pixel of a window; -1 = none.
std::vector<int8_t> CostVolume::labels_behind(const Window& window) const {
  const Tables& t = *tables_;
  const int labels = t.options.labels;
  std::vector<int8_t> nearest;
  nearest.reserve(static_cast<size_t>(window.width) * static_cast<size_t>(window.height));
  for (int x = 0; x < window.width; ++x) {
    const int column = t.grid.wraps ? (window.x + x) % t.grid.width : window.x + x;
    for (int y = 0; y < window.height; ++y) {
      // The largest label with (2 label + 1) kDisparitySteps < 2 (labels - 1) front.
      const int front = t.behind->at(column, window.y + y);
      const int halves = (2 * (labels - 1) * front + kDisparitySteps - 1) / kDisparitySteps - 1;
      nearest.push_back(static_cast<int8_t>(front == kNoDisparity ? labels - 1 : halves < 1 ? -1 : (halves - 1) / 2));
    }
  }
  return nearest;
}

// The smallest part of the window with all pixels that may take a label; no columns where there are none.
Window CostVolume::part_with_label(const Window& window, const std::vector<int8_t>& nearest, int label) {
  int left = window.width, right = 0, top = window.height, bottom = 0;
  for (int x = 0; x < window.width; ++x) {
    const int8_t* column = nearest.data() + static_cast<ptrdiff_t>(x) * window.height;
    int first = 0, last = window.height;
    while (first < last && column[first] < label) ++first;
    while (last > first && column[last - 1] < label) --last;
    if (first == last) continue;
    left = std::min(left, x);
    right = x + 1;
    top = std::min(top, first);
    bottom = std::max(bottom, last);
  }
  if (left >= right) return {};
  return {window.x + left, window.y + top, right - left, bottom - top};
}

// Labels in front cost most; their grey, which hardly matters then, is that of the nearest label behind.
void CostVolume::forbid_front(const std::vector<int8_t>& nearest, uint8_t* cost, uint8_t* median) const {
  const int labels = tables_->options.labels;
  for (const int8_t allowed : nearest) {
    for (int label = allowed + 1; label < labels; ++label) {
      cost[label] = kForbiddenCost;
      median[label] = allowed >= 0 ? median[allowed] : kMiddleGrey;
    }
    cost += labels;
    median += labels;
  }
}

// Labels that fewer than two cameras see cannot be matched. Dear, they would draw the surface to where two cameras see,
// along the border of the outermost photo; so they cost little more than the ray's best match, and smoothness decides.
// Where even the best matches badly, it is dear itself.
void CostVolume::rate_unmatched(const Window& window, uint8_t* cost) const {
  const Tables& t = *tables_;
  const auto labels = static_cast<size_t>(t.options.labels);
  std::vector<uint16_t> matched(static_cast<size_t>(window.height));  // a bit per label
  for (int x = 0; x < window.width; ++x) {
    t.labels_seen_twice(window.x + x, window.y, matched);
    for (const uint16_t seen : matched) {
      int least = t.options.unmatched_cost;
      for (size_t l = 0; l < labels; ++l)
        if (seen >> l & 1) least = std::min<int>(least, cost[l]);
      const auto most = static_cast<uint8_t>(std::min(least + t.options.margin, t.options.unmatched_cost));
      for (size_t l = 0; l < labels; ++l)
        if (!(seen >> l & 1) && cost[l] != kForbiddenCost) cost[l] = std::min(cost[l], most);
      cost += labels;
    }
  }
}

void CostVolume::equal_where_plain(const SweepScratch& found, size_t pixels, uint8_t* cost) const {
  constexpr int kRange = kNoLongerPlain - kPlainContrast;
  const auto labels = static_cast<size_t>(tables_->options.labels);
  for (size_t i = 0; i < pixels; ++i) {
    const int more = std::min(kNoLongerPlain - found.contrast_at_least[i], kRange);
    if (more <= 0) continue;
    const int least = std::min(found.least[i] + kPlainDifference * more / kRange, kForbiddenCost - 1);
    for (size_t l = i * labels; l < (i + 1) * labels; ++l) cost[l] = std::max(cost[l], static_cast<uint8_t>(least));
  }
}

void CostVolume::draw_to_points(const SweepScratch& found, const Window& window, uint8_t* cost) const {
  constexpr int kSteps = PointsPrior::kLabelSteps, kRange = kPointsContrast - kPointsFullContrast;
  constexpr int kUnit = kPointsLabelsPerUnit * kRange * PointsPrior::kFull * kSteps;  // of the product below
  const int labels = tables_->options.labels;
  size_t i = 0;
  for (int x = window.x; x < window.x + window.width; ++x)
    for (int y = window.y; y < window.y + window.height; ++y, ++i, cost += labels) {
      const int plain = std::min(kPointsContrast - found.contrast_at_least[i], kRange);
      if (plain <= 0) continue;
      const PointsPrior::Expectation expected = tables_->points->at(x, y);
      for (int l = 0; l < labels && expected.weight > 0; ++l) {
        const int off = std::abs(l * kSteps - expected.label) - kPointsSlack * kSteps;
        const int more = (plain * expected.weight * std::clamp(off, 0, kPointsMost * kSteps) + kUnit / 2) / kUnit;
        cost[l] = static_cast<uint8_t>(std::min(cost[l] + more, kForbiddenCost - 1));
      }
    }
}

}  // namespace ldp
