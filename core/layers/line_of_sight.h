// Which cameras see a voxel on a pixel that no layer covers.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "core/geometry/visibility_map.h"
#include "core/geometry/voxel_projection.h"
#include "core/layers/layers.h"
#include "core/photos/upright_frame.h"

namespace ldp::layers {

// Per frame, by columns: not 0 where no layer covers the pixel or one of its eight neighbours.
using UncoveredMaps = std::vector<Plane<uint8_t>>;

// The voxels of one column at one inverse depth, as one camera's map sees them: one map column, rows affine in v.
struct VoxelColumn {
  const uint8_t* uncovered;    // the map's column
  int valid_begin, valid_end;  // rows of the upright frame's column
  double slope, offset;        // upright row = offset + slope v
};

// From all cameras.
struct LinesOfSight {
  const std::vector<UprightFrame>& frames;
  std::vector<VoxelProjection> projections;
  UncoveredMaps uncovered_maps;

  LinesOfSight(const PanoramaGrid& grid, const CameraViews& views, const Job& job);
};

// The cameras that may see any voxel of a column.
struct FacingCameras {
  Heading heading;
  std::vector<size_t> frames;

  FacingCameras(const PanoramaGrid& grid, const LinesOfSight& sight, int x);
};

// Those of them that see the column's voxels at inverse depth w.
void find_voxel_columns(const LinesOfSight& sight, const FacingCameras& facing, double w,
                        std::vector<VoxelColumn>& seen);

// Does the voxel fall on a pixel that no layer covers, or beside one?
inline bool falls_on_uncovered(const VoxelColumn& voxels, double v) {
  const double y_px = voxels.offset + voxels.slope * v;
  if (!(y_px >= voxels.valid_begin && y_px < voxels.valid_end)) return false;
  const int row = static_cast<int>(y_px);
  return voxels.uncovered[row] != 0;
}

}  // namespace ldp::layers
