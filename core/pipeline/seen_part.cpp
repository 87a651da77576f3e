#include "core/pipeline/seen_part.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/disparity.h"
#include "core/geometry/voxel_projection.h"
#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

using namespace pipeline;  // tuned constants

constexpr int kFewestCells = 8;  // in a row or column
constexpr int kCellPx = 4;       // columns and rows of the grid to one of cells
constexpr int kBeside = 1;       // cells around what is seen that may be

PanoramaGrid coarser(const PanoramaGrid& grid) {
  PanoramaGrid coarse = grid;
  coarse.width = (grid.width + kCellPx - 1) / kCellPx;
  coarse.height = (grid.height + kCellPx - 1) / kCellPx;
  coarse.theta_pitch = grid.wraps ? grid.theta_pitch * grid.width / coarse.width : grid.theta_pitch * kCellPx;
  coarse.v_pitch = grid.v_pitch * kCellPx;
  return coarse;
}

// The rows of a coarse column that some photo sees.
class ColumnsSeen {
 public:
  ColumnsSeen(const std::vector<UprightFrame>& upright, const PanoramaGrid& coarse) : upright_(upright), grid_(coarse) {
    for (const UprightFrame& frame : upright) projections_.emplace_back(coarse, frame.camera);
  }

  // Per row, 1 where one sees it at some label.
  std::vector<uint8_t> rows(int x) const {
    std::vector<uint8_t> rows(static_cast<size_t>(grid_.height), 0);
    const Heading outward = heading(grid_.theta(x + 0.5));
    for (int label = 0; label < kLabels; ++label)
      for (size_t k = 0; k < upright_.size(); ++k) mark(k, projections_[k].column(outward), label, rows);
    return rows;
  }

 private:
  void mark(size_t k, VoxelProjection::Column u, int label, std::vector<uint8_t>& rows) const {
    const VoxelProjection& projection = projections_[k];
    const double w = grid_.inverse_depth(1.0 * label * kDisparitySteps / (kLabels - 1)),
                 forward = projection.forward(u, w);
    if (forward < kLeastForward) return;
    const double x_px = projection.x_px(u, w);
    if (!(x_px >= 0 && x_px < upright_[k].camera.width)) return;
    const auto column = static_cast<size_t>(x_px);
    const double offset = projection.row_offset(w, forward), slope = projection.row_slope(forward);
    const auto row = [&](int y_px) {
      const double at = (grid_.v_top - (y_px - offset) / slope) / grid_.v_pitch;
      return std::clamp(at, 0.0, static_cast<double>(grid_.height));
    };
    const int first = upright_[k].valid_begin[column], last = upright_[k].valid_end[column];
    if (first >= last) return;
    for (auto y = static_cast<size_t>(row(first)), end = static_cast<size_t>(std::ceil(row(last))); y < end; ++y)
      rows[y] = 1;
  }

  const std::vector<UprightFrame>& upright_;
  const PanoramaGrid& grid_;
  std::vector<VoxelProjection> projections_;
};

// Calls `use` for all cells around a place, itself among them.
template <typename Use>
void for_cells_beside(const PanoramaGrid& grid, int x, int y, const Use& use) {
  for (int i = x - kBeside; i <= x + kBeside; ++i) {
    if (!grid.wraps && (i < 0 || i >= grid.width)) continue;
    for (int j = std::max(0, y - kBeside); j <= std::min(y + kBeside, grid.height - 1); ++j)
      use((i + grid.width) % grid.width, j);
  }
}

Plane<uint8_t> cells_seen(const std::vector<UprightFrame>& upright, const PanoramaGrid& coarse, const Job& job) {
  const ColumnsSeen columns(upright, coarse);
  Plane<uint8_t> seen(coarse.width, coarse.height), widened = seen;
  parallel_for(job, coarse.width, [&](int x) {
    const std::vector<uint8_t> rows = columns.rows(x);
    for (int y = 0; y < coarse.height; ++y) seen.at(x, y) = rows[static_cast<size_t>(y)];
  });
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x)
      for_cells_beside(coarse, x, y, [&](int i, int j) { widened.at(x, y) |= seen.at(i, j); });
  return widened;
}

// The smallest window with all cells seen.
Window box_of(const Plane<uint8_t>& seen) {
  int left = seen.width, right = 0, top = seen.height, bottom = 0;
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      if (!seen.at(x, y)) continue;
      left = std::min(left, x), right = std::max(right, x + 1);
      top = std::min(top, y), bottom = std::max(bottom, y + 1);
    }
  return {left, top, right - left, bottom - top};
}

// The part of the grid that a window of cells stands for.
Window pixels_of(const Window& cells, const PanoramaGrid& grid) {
  const int x = grid.wraps ? 0 : cells.x * kCellPx, y = cells.y * kCellPx;
  const int right = grid.wraps ? grid.width : std::min(grid.width, (cells.x + cells.width) * kCellPx);
  return {x, y, right - x, std::min(grid.height, (cells.y + cells.height) * kCellPx) - y};
}

}  // namespace

SeenPart find_seen_part(const std::vector<UprightFrame>& upright, const PanoramaGrid& grid, const Job& job) {
  const PanoramaGrid coarse = coarser(grid);
  const Window all{0, 0, grid.width, grid.height};
  if (std::min(coarse.width, coarse.height) < kFewestCells) return {all, {}};
  const Plane<uint8_t> cells = cells_seen(upright, coarse, job);
  const Window found = box_of(cells);
  if (found.width <= 0) return {all, {}};
  SeenPart part{pixels_of(found, grid), {}};
  part.mask = Plane<uint8_t>(part.box.width, part.box.height);
  for (int y = 0; y < part.box.height; ++y)
    for (int x = 0; x < part.box.width; ++x) {
      const int column =
          grid.wraps ? static_cast<int>(int64_t{x} * coarse.width / grid.width) : (part.box.x + x) / kCellPx;
      part.mask.at(x, y) = cells.at(column, (part.box.y + y) / kCellPx);
    }
  const auto masked = std::count(part.mask.samples.begin(), part.mask.samples.end(), uint8_t{1});
  if (masked * kWorthLeavingOut > int64_t{grid.width} * grid.height * (kWorthLeavingOut - 1)) return {all, {}};
  return part;
}

}  // namespace ldp
