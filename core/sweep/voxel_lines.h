// Where the vertical line of voxels at (column, disparity) lies in each upright frame: one fractional image column,
// rows affine in the panorama's row. Computed in double with exactly rounded operations only, then rounded to fixed
// point, so that positions are the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/geometry/visibility_map.h"
#include "core/geometry/voxel_projection.h"
#include "core/photos/upright_frame.h"
#include "core/sweep/sweep_kernels.h"

namespace ldp::sweep {

// The line in one frame. Row of the panorama's row y: (row_q16 + y step_q16) / 65536 samples from the first.
struct Line {
  struct Columns {  // of the image, between which it runs
    const uint8_t *left = nullptr, *right = nullptr;
  };
  Columns grey, tint;
  const uint16_t* surface = nullptr;  // column of the visibility map; null = everything is visible
  int64_t row_q16 = 0;
  int32_t step_q16 = 0;
  int weight = 0;              // of `right`, in 1/64
  int surface_limit = 0;       // hidden where surface[row] > limit
  int y_begin = 0, y_end = 0;  // panorama rows whose samples lie inside the photo
};

struct Lines {
  std::array<Line, kernels::kMaxViews> line;
  int count = 0;
};

class LineTable {
 public:
  enum class Layer { front, behind };

  // Frames, and visibility unless empty, must outlive the table. `margin_px`: columns past the grid's ends that may be
  // asked for. On the front layer the camera nearest to a ray sees every voxel: what hides one from it would itself be
  // the front. (Without this the scene behind a thing, seen past it by others, matches as well as the thing itself.)
  LineTable(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid,
            const std::vector<VisibilityMap>& visibility, int margin_px, Layer layer);

  // The lines of a column (-margin .. width + margin, modulo the width when the grid wraps) at an inverse depth, cut to
  // the rows [y_begin, y_end): the kMaxViews cameras that look most nearly the same way, or that stand apart where
  // these are close together, among those that see any of it.
  void find(int column, double inverse_depth, int y_begin, int y_end, Lines& lines) const;

 private:
  std::vector<uint16_t> views_of(Heading outward) const;  // best first
  // Of photos taken densely the nearest show next to no parallax: those that stand apart go before those between them.
  void spread(Heading outward, std::vector<uint16_t>& views) const;
  bool make_line(size_t view, Heading outward, double inverse_depth, Line& line) const;
  size_t slot(int column) const;

  const std::vector<UprightFrame>& frames_;
  PanoramaGrid grid_;
  const std::vector<VisibilityMap>* visibility_ = nullptr;  // null = everything is visible
  int margin_px_ = 0;
  Layer layer_ = Layer::front;
  std::vector<VoxelProjection> projections_;
  std::vector<Heading> outward_;                        // of each column's centre
  std::vector<std::vector<uint16_t>> views_of_column_;  // best first
};

}  // namespace ldp::sweep
