#include <algorithm>

#include "core/layers/layers.h"
#include "core/layers/line_of_sight.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

void mark_boundary(const PanoramaGrid& grid, const DisparityMap& front, int gap, Plane<uint8_t>& want) {
  const auto behind_wanted = [&](int x, int y, int d) {
    const int column = neighbour_column(grid, x);
    return column >= 0 && y >= 0 && y < grid.height && want.at(column, y) == kWanted && front.at(column, y) >= d + gap;
  };
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const int d = front.at(x, y);
      if (want.at(x, y) == kWanted || d == kNoDisparity) continue;
      if (behind_wanted(x - 1, y, d) || behind_wanted(x + 1, y, d) || behind_wanted(x, y - 1, d) ||
          behind_wanted(x, y + 1, d))
        want.at(x, y) = kBoundary;
    }
}

// A row of a column of which it is not known yet whether it is wanted.
constexpr int kSettled = -1;
struct OpenRow {
  int y;
  int nearest;  // of the disparities that lie behind; kSettled: it is known now
  double v;
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

Plane<uint8_t> wanted_behind(const PanoramaGrid& grid, const DisparityMap& front, const CameraViews& views,
                             const LayersOptions& options, const Job& job) {
  const LinesOfSight sight(grid, views, job);
  const int gap = gap_steps(grid, options);
  Plane<uint8_t> want(grid.width, grid.height, kUnwanted);
  parallel_for(job, grid.width, [&](int x) {
    const FacingCameras facing(grid, sight, x);
    std::vector<OpenRow> open;
    for (int y = 0; y < grid.height; ++y)
      if (front.at(x, y) != kNoDisparity) open.push_back({y, front.at(x, y) - gap, grid.v(y + 0.5)});
    std::vector<VoxelColumn> columns;
    for (int d = 0; !open.empty(); d += kLabelSteps / 2) {
      std::erase_if(open, [d](const OpenRow& row) { return row.nearest < d; });
      find_voxel_columns(sight, facing, grid.inverse_depth(d), columns);
      for (const VoxelColumn& voxels : columns)
        for (OpenRow& row : open) {
          if (row.nearest == kSettled || !falls_on_uncovered(voxels, row.v)) continue;
          want.at(x, row.y) = kWanted;
          row.nearest = kSettled;
        }
    }
  });
  mark_boundary(grid, front, gap, want);
  return want;
}

int drop_unseen(const PanoramaGrid& grid, const CameraViews& views, const Job& job, DisparityMap& layer) {
  const LinesOfSight sight(grid, views, job);
  std::vector<int> kept(static_cast<size_t>(grid.width), 0);
  parallel_for(job, grid.width, [&](int x) {
    const FacingCameras facing(grid, sight, x);
    int cached = -1;
    std::vector<VoxelColumn> columns;
    for (int y = 0; y < grid.height; ++y) {
      uint16_t& d = layer.at(x, y);
      if (d == kNoDisparity) continue;
      if (d != cached) find_voxel_columns(sight, facing, grid.inverse_depth(d), columns);
      cached = d;
      const double v = grid.v(y + 0.5);
      const bool seen =
          std::any_of(columns.begin(), columns.end(), [&](const VoxelColumn& c) { return falls_on_uncovered(c, v); });
      if (seen)
        ++kept[static_cast<size_t>(x)];
      else
        d = kNoDisparity;
    }
  });
  int total = 0;
  for (int k : kept) total += k;
  return total;
}

}  // namespace ldp
