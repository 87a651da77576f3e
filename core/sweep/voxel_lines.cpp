#include "core/sweep/voxel_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/sweep/sweep_tuning.h"

namespace ldp::sweep {
namespace {

using namespace tuning;

constexpr double kInFront = 1e-3;  // forward * w of a voxel worth projecting
constexpr double kLargestRow = 1 << 20;
constexpr int kHidesNothing = 65535;  // the nearest that a surface can be

// The library's floor, and divisions of 64-bit integers, are slow where processors lack them.
int64_t floor_of(double value) {
  const auto whole = static_cast<int64_t>(value);
  return whole - (static_cast<double>(whole) > value ? 1 : 0);
}

// The quotient's rounding does not reach a whole number: a and b stay below 2^52.
int64_t ceil_div(int64_t a, int64_t b) { return -floor_of(static_cast<double>(-a) / static_cast<double>(b)); }

}  // namespace

LineTable::LineTable(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid,
                     const std::vector<VisibilityMap>& visibility, int margin_px, Layer layer)
    : frames_(frames),
      grid_(grid),
      visibility_(visibility.empty() ? nullptr : &visibility),
      margin_px_(margin_px),
      layer_(layer) {
  for (const UprightFrame& frame : frames) projections_.emplace_back(grid, frame.camera, Rounding::none);
  const int columns = grid.wraps ? grid.width : grid.width + 2 * margin_px;
  for (int i = 0; i < columns; ++i) {
    const Heading outward = heading(grid.theta((grid.wraps ? i : i - margin_px) + 0.5), Rounding::none);
    outward_.push_back(outward);
    views_of_column_.push_back(views_of(outward));
  }
}

std::vector<uint16_t> LineTable::views_of(Heading outward) const {
  std::vector<std::pair<double, uint16_t>> seen;
  for (size_t k = 0; k < projections_.size(); ++k)
    if (projections_[k].column(outward).forward > kLeastCosine)
      seen.emplace_back(std::abs(projections_[k].aside(outward)), static_cast<uint16_t>(k));
  std::sort(seen.begin(), seen.end());
  std::vector<uint16_t> views;
  for (const auto& [aside, view] : seen) views.push_back(view);
  spread(outward, views);
  return views;
}

void LineTable::spread(Heading outward, std::vector<uint16_t>& views) const {
  std::vector<double> places;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  double first = kInfinite, last = -kInfinite;  // of the nearest that show it, to either side
  int count = 0;
  for (const uint16_t view : views) {
    const VoxelProjection& projection = projections_[view];
    places.push_back(projection.aside(outward));
    const double x_px = projection.x_px(projection.column(outward), grid_.w_far);
    if (count == kernels::kMaxViews || !(x_px >= 0 && x_px < frames_[view].camera.width)) continue;
    ++count;
    first = std::min(first, places.back());
    last = std::max(last, places.back());
  }
  const double range = grid_.w_near - grid_.w_far;
  if (count < kernels::kMaxViews || (last - first) * range >= kLeastParallax) return;
  const double least = kLeastParallax / range / (kernels::kMaxViews - 1);
  std::vector<uint16_t> apart, between;
  std::vector<double> taken;
  for (size_t i = 0; i < views.size(); ++i) {
    const bool is_between =
        std::any_of(taken.begin(), taken.end(), [&](double place) { return std::abs(place - places[i]) < least; });
    (is_between ? between : apart).push_back(views[i]);
    if (!is_between) taken.push_back(places[i]);
  }
  apart.insert(apart.end(), between.begin(), between.end());
  views = std::move(apart);
}

size_t LineTable::slot(int column) const {
  if (!grid_.wraps) return static_cast<size_t>(column + margin_px_);
  const int wrapped = column % grid_.width;
  return static_cast<size_t>(wrapped < 0 ? wrapped + grid_.width : wrapped);
}

void LineTable::find(int column, double inverse_depth, int y_begin, int y_end, Lines& lines) const {
  const size_t at = slot(column);
  lines.count = 0;
  for (const uint16_t view : views_of_column_[at]) {
    if (lines.count == kernels::kMaxViews) break;
    Line& line = lines.line[static_cast<size_t>(lines.count)];
    if (!make_line(view, outward_[at], inverse_depth, line)) continue;
    line.y_begin = std::max(line.y_begin, y_begin);
    line.y_end = std::min(line.y_end, y_end);
    if (lines.count == 0 && layer_ == Layer::front) line.surface_limit = kHidesNothing;
    if (line.y_begin < line.y_end) ++lines.count;
  }
}

bool LineTable::make_line(size_t view, Heading outward, double w, Line& line) const {
  const VoxelProjection& projection = projections_[view];
  const UprightFrame& frame = frames_[view];
  const UprightCamera& camera = frame.camera;
  const VoxelProjection::Column u = projection.column(outward);
  const double forward = projection.forward(u, w);
  if (forward <= kInFront) return false;
  const double scale = camera.focal / forward;
  const double x_px = (scale * projection.right(u, w) + camera.cx - 0.5) * kernels::kWeightOne + 0.5;
  if (!(x_px >= 0 && x_px < (camera.width - 1) * static_cast<double>(kernels::kWeightOne))) return false;
  const int x_q6 = static_cast<int>(x_px), x = x_q6 >> kernels::kWeightBits;
  line.weight = x_q6 & (kernels::kWeightOne - 1);
  const double step = scale * grid_.v_pitch;
  const double row = camera.cy - 0.5 - scale * projection.up(grid_.v(0.5), w);
  if (step > kLargestStep || std::abs(row) > kLargestRow) return false;
  line.step_q16 = static_cast<int32_t>(floor_of(step * 65536 + 0.5));
  line.row_q16 = floor_of(row * 65536 + 0.5) + (65536 / kernels::kWeightOne / 2);
  line.grey = {frame.columns.row(x), frame.columns.row(x + 1)};
  line.tint = {frame.tint.row(x), frame.tint.row(x + 1)};
  const auto c = static_cast<size_t>(x);
  const int64_t first = std::max(frame.valid_begin[c], frame.valid_begin[c + 1]),
                last = std::min(frame.valid_end[c], frame.valid_end[c + 1]) - 1;
  if (first >= last || line.step_q16 <= 0) return false;
  constexpr int64_t kFar = 1 << 30;
  line.y_begin = static_cast<int>(std::clamp(ceil_div(first * 65536 - line.row_q16, line.step_q16), -kFar, kFar));
  line.y_end = static_cast<int>(std::clamp(ceil_div(last * 65536 - line.row_q16, line.step_q16), -kFar, kFar));
  if (!visibility_) return true;
  const VisibilityMap& map = (*visibility_)[view];
  const int nearest = line.weight < kernels::kWeightOne / 2 ? x : x + 1;
  line.surface = map.inverse_z.row(std::min(nearest, map.inverse_z.height - 1));
  line.surface_limit = static_cast<int>(std::min(w / forward / map.scale, 65535.0)) + map.tolerance;
  return true;
}

}  // namespace ldp::sweep
