#include "core/sweep/cost_slab.h"

#include <algorithm>

namespace ldp::sweep {
namespace {

// The rows of one column of voxels and the cameras that see them.
class Column {
 public:
  Column(const Lines& lines, int y_begin, int y_end, int prior_cost, SlabScratch& scratch)
      : lines_(lines), y_begin_(y_begin), y_end_(y_end), prior_cost_(prior_cost), scratch_(scratch) {}

  void compute(uint8_t* phi, const kernels::Tinted<uint8_t>& reference) {
    for (int k = 0; k < lines_.count; ++k) sample(k);
    for (int y = y_begin_; y < y_end_;) {
      const int end = segment_end(y);
      const int at = y - y_begin_;
      vary(y, end, phi + at, {reference.grey + at, reference.tint + at});
      y = end;
    }
  }

 private:
  const Line& line(int k) const { return lines_.line[static_cast<size_t>(k)]; }
  bool sees(const Line& l, int y) const { return y >= l.y_begin && y < l.y_end; }

  void sample(int k) {
    const Line& l = line(k);
    const int count = l.y_end - l.y_begin;
    const int64_t first_q16 = l.row_q16 + static_cast<int64_t>(l.step_q16) * l.y_begin;
    const auto first = static_cast<int>(first_q16 >> 16);
    const auto last = static_cast<int>((first_q16 + static_cast<int64_t>(l.step_q16) * (count - 1)) >> 16) + 1;
    const auto blend = [&](const Line::Columns& from, std::vector<uint8_t>& to) {
      scratch_.kernels.blend_columns(from.left + first, from.right + first, l.weight, last - first + 1, to.data());
    };
    blend(l.grey, scratch_.blended);
    blend(l.tint, scratch_.blended_tint);
    const int offset = l.y_begin - y_begin_;
    scratch_.kernels.resample_rows({scratch_.blended.data(), scratch_.blended_tint.data()}, first_q16 & 0xFFFF,
                                   l.step_q16, count,
                                   {scratch_.samples[k].data() + offset, scratch_.tints[k].data() + offset});
    if (l.surface) {
      uint8_t* mask = scratch_.masks[k].data() + (l.y_begin - y_begin_);
      scratch_.kernels.test_visibility(l.surface, first_q16, l.step_q16, l.surface_limit, count, mask);
      masked_ = true;
    }
  }

  // The rows from y on that the same cameras see.
  int segment_end(int y) const {
    int end = y_end_;
    for (int k = 0; k < lines_.count; ++k) {
      if (line(k).y_begin > y) end = std::min(end, line(k).y_begin);
      if (line(k).y_end > y) end = std::min(end, line(k).y_end);
    }
    return end;
  }

  void vary(int y, int end, uint8_t* phi, const kernels::Tinted<uint8_t>& reference) {
    const uint8_t* samples[kernels::kMaxViews];
    const uint8_t* tints[kernels::kMaxViews];
    const uint8_t* masks[kernels::kMaxViews];
    int views = 0;
    for (int k = 0; k < lines_.count; ++k) {
      if (!sees(line(k), y)) continue;
      samples[views] = scratch_.samples[k].data() + (y - y_begin_);
      tints[views] = scratch_.tints[k].data() + (y - y_begin_);
      masks[views++] = scratch_.masks[k].data() + (y - y_begin_);
    }
    const int count = end - y;
    if (views > 0 && masked_)
      return scratch_.kernels.masked_robust_variance({samples, tints}, masks, views, prior_cost_, count, phi,
                                                     reference);
    if (views > 1) return scratch_.kernels.robust_variance({samples, tints}, views, count, phi, reference);
    std::fill(phi, phi + count, static_cast<uint8_t>(prior_cost_));
    if (views == 1) {
      std::copy(samples[0], samples[0] + count, reference.grey);
      std::copy(tints[0], tints[0] + count, reference.tint);
    } else {
      std::fill(reference.grey, reference.grey + count, uint8_t{128});
      std::fill(reference.tint, reference.tint + count, uint8_t{128});
    }
  }

  const Lines& lines_;
  int y_begin_, y_end_, prior_cost_;
  SlabScratch& scratch_;
  bool masked_ = false;
};

template <typename T>
void grow(std::vector<T>& buffer, int size) {
  const auto wanted = static_cast<size_t>(size + kernels::kPadding);
  if (buffer.size() < wanted) buffer.resize(wanted);
}

// The ranges of one more column; once there are kSupport, the contrast of windows over them.
void take_range(int column, const uint8_t* grey, int count, SlabScratch& scratch) {
  auto &greys = scratch.greys[column % kSupport], &hues = scratch.hues[column % kSupport];
  scratch.kernels.range7(grey, count, greys.low.data(), greys.high.data());
  scratch.kernels.range7(scratch.reference_tint.data(), count, hues.low.data(), hues.high.data());
  if (column < kSupport - 1) return;
  kernels::Tinted<const uint8_t> low[kSupport], high[kSupport];
  for (int k = 0; k < kSupport; ++k) {
    low[k] = {scratch.greys[k].low.data(), scratch.hues[k].low.data()};
    high[k] = {scratch.greys[k].high.data(), scratch.hues[k].high.data()};
  }
  scratch.kernels.contrast7(low, high, count, scratch.contrast.data());
}

}  // namespace

void SlabScratch::reserve(int height, int longest_column) {
  const int rows = height + 2 * kHalo;
  grow(blended, longest_column);
  grow(blended_tint, longest_column);
  for (auto& buffer : samples) grow(buffer, rows);
  for (auto& buffer : tints) grow(buffer, rows);
  for (auto& buffer : masks) grow(buffer, rows);
  for (auto& buffer : medians) grow(buffer, rows);
  for (auto& buffer : sums) grow(buffer, rows);
  for (auto& buffer : lowest) grow(buffer, rows);
  for (auto* ranges : {greys, hues})
    for (int k = 0; k < kSupport; ++k) {
      grow(ranges[k].low, rows);
      grow(ranges[k].high, rows);
    }
  grow(contrast, rows);
  grow(reference_tint, rows);
  for (auto& buffer : phi) grow(buffer, rows);
  grow(total, rows);
  grow(box, rows);
  grow(cost, rows);
}

void sweep_slab(const LineTable& lines, double inverse_depth, const Window& window, int prior_cost, bool with_contrast,
                SlabScratch& scratch, SlabSink& sink) {
  const int y_begin = window.y - kHalo, y_end = window.y + window.height + kHalo;
  const int boxes = window.height + 2;  // rows whose box is needed
  std::fill(scratch.total.begin(), scratch.total.end(), uint16_t{0});
  for (auto& sums : scratch.sums) std::fill(sums.begin(), sums.end(), uint16_t{0});
  Lines found;
  for (int i = 0; i < window.width + 2 * kHalo; ++i) {
    lines.find(window.x - kHalo + i, inverse_depth, y_begin, y_end, found);
    uint8_t *grey = scratch.medians[i % kSupport].data(), *phi = scratch.phi[i % kSupport].data();
    Column(found, y_begin, y_end, prior_cost, scratch).compute(phi, {grey, scratch.reference_tint.data()});
    if (with_contrast) take_range(i, grey, window.height, scratch);
    uint16_t* leaving = scratch.sums[i % 5].data();
    uint16_t* total = scratch.total.data();
    // The sums that leave make room for those that enter.
    uint16_t* entering = scratch.cost.data();
    scratch.kernels.sum5(phi, boxes, entering);
    scratch.kernels.slide(entering, leaving, boxes, total);
    std::copy(entering, entering + boxes, leaving);
    if (i < 4) continue;
    scratch.kernels.min3_rows(total, window.height, scratch.lowest[i % 3].data());
    if (i < 2 * kHalo) continue;
    scratch.kernels.min3_columns(scratch.lowest[0].data(), scratch.lowest[1].data(), scratch.lowest[2].data(),
                                 window.height, scratch.box.data());
    const uint8_t *costs[kSupport], *greys[kSupport];  // of the columns around the one that is complete now
    for (int k = 0; k < kSupport; ++k) {
      costs[k] = scratch.phi[(i + 1 + k) % kSupport].data();
      greys[k] = scratch.medians[(i + 1 + k) % kSupport].data();
    }
    scratch.kernels.adaptive_support(costs, greys, scratch.box.data(), window.height, scratch.cost.data());
    sink.column(i - 2 * kHalo, scratch.cost.data(), greys[kHalo] + kHalo,
                with_contrast ? scratch.contrast.data() : nullptr);
  }
}

}  // namespace ldp::sweep
