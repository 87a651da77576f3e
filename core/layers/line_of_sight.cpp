#include "core/layers/line_of_sight.h"

#include <algorithm>

#include "core/geometry/disparity.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

Plane<uint8_t> uncovered(const VisibilityMap& map) {
  const int rows = map.inverse_z.width, columns = map.inverse_z.height;
  Plane<uint8_t> along(rows, columns), near(rows, columns);
  std::vector<uint8_t> open(static_cast<size_t>(rows) + 2);
  for (int column = 0; column < columns; ++column) {
    const uint16_t* surface = map.inverse_z.row(column);
    for (int row = 0; row < rows; ++row) open[static_cast<size_t>(row) + 1] = surface[row] == kUncovered;
    uint8_t* out = along.row(column);
    for (int row = 0; row < rows; ++row) {
      const uint8_t* at = open.data() + row;
      out[row] = at[0] | at[1] | at[2];
    }
  }
  for (int column = 0; column < columns; ++column) {
    const uint8_t *before = along.row(std::max(0, column - 1)), *here = along.row(column),
                  *after = along.row(std::min(columns - 1, column + 1));
    uint8_t* out = near.row(column);
    for (int row = 0; row < rows; ++row) out[row] = before[row] | here[row] | after[row];
  }
  return near;
}

UncoveredMaps uncovered(const std::vector<VisibilityMap>& maps, const Job& job) {
  UncoveredMaps uncovered_maps(maps.size());
  parallel_for(job, static_cast<int>(maps.size()),
               [&](int i) { uncovered_maps[static_cast<size_t>(i)] = uncovered(maps[static_cast<size_t>(i)]); });
  return uncovered_maps;
}

}  // namespace

LinesOfSight::LinesOfSight(const PanoramaGrid& grid, const CameraViews& views, const Job& job)
    : frames(views.frames), uncovered_maps(uncovered(views.maps, job)) {
  projections.reserve(frames.size());
  for (const UprightFrame& frame : frames) projections.emplace_back(grid, frame.camera);
}

FacingCameras::FacingCameras(const PanoramaGrid& grid, const LinesOfSight& sight, int x)
    : heading(ldp::heading(grid.theta(x + 0.5))) {
  const double w[2] = {grid.inverse_depth(0), grid.inverse_depth(kDisparitySteps)};
  for (size_t i = 0; i < sight.frames.size(); ++i) {
    const VoxelProjection& projection = sight.projections[i];
    const auto u = projection.column(heading);
    const double forward[2] = {projection.forward(u, w[0]), projection.forward(u, w[1])};
    if (forward[0] < 0.09 && forward[1] < 0.09) continue;
    if (forward[0] > kLeastForward && forward[1] > kLeastForward) {  // then its place is monotonic in inverse depth
      const auto [first, last] = std::minmax({projection.x_px(u, w[0]), projection.x_px(u, w[1])});
      if (last < -1 || first > sight.frames[i].camera.width + 1) continue;
    }
    frames.push_back(i);
  }
}

void find_voxel_columns(const LinesOfSight& sight, const FacingCameras& facing, double w,
                        std::vector<VoxelColumn>& seen) {
  seen.clear();
  for (const size_t i : facing.frames) {
    const VoxelProjection& projection = sight.projections[i];
    const auto u = projection.column(facing.heading);
    const double forward = projection.forward(u, w);
    if (forward < kLeastForward) continue;
    const double x_px = projection.x_px(u, w);
    if (!(x_px >= 0 && x_px < sight.frames[i].camera.width)) continue;
    const int column = static_cast<int>(x_px);
    const auto index = static_cast<size_t>(column);
    seen.push_back({sight.uncovered_maps[i].row(column), sight.frames[i].valid_begin[index],
                    sight.frames[i].valid_end[index], projection.row_slope(forward),
                    projection.row_offset(w, forward)});
  }
}

}  // namespace ldp::layers
