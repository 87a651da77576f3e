// Draws layers into what one camera sees first: every pixel of a layer is a rectangle that shares its sides with
// neighbours on the same surface.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/scratch_pool.h"
#include "core/geometry/voxel_projection.h"
#include "core/layers/layers.h"
#include "core/layers/neighbours.h"
#include "core/layers/painting/view_kernels.h"

namespace ldp::layers {

// What painting a layer into any camera's map needs. Columns are padded for the kernels.
struct Brush {
  const PanoramaGrid& grid;
  std::vector<Heading> edges;
  std::vector<float> edges_v;
  Plane<uint16_t> columns;  // the layer's
  Plane<uint8_t> joined;    // 1 where a pixel is on one surface with the next column's, stored likewise

  Brush(const PanoramaGrid& on, const DisparityMap& layer, const LayersOptions& options);
};

// Which of the panorama's pixels each of a map's pixels shows, stored like the map: column times height, plus row.
using SeenPixels = Plane<uint32_t>;
constexpr uint32_t kSeesNothing = 0xFFFFFFFF;

class MapPainter {
 public:
  // `seen` may be null; what is given must outlive it. Both hold every columns_apart-th column of the camera, from its
  // first.
  MapPainter(const Brush& brush, const UprightCamera& camera, VisibilityMap& map, SeenPixels* seen = nullptr,
             int columns_apart = 1);

  // One column of the layer.
  void paint(int x);

 private:
  struct Sides {  // of a column
    VoxelProjection::Column left, right;
  };

  bool in_view(Heading h) const;
  bool beside_view(const Sides& sides) const;
  kernels::DisparityColumn column(int x) const;
  kernels::ColumnInView projected(const Sides& sides) const;
  void draw_boxes(int x);

  const PanoramaGrid& grid_;
  const Brush& brush_;
  const UprightCamera& camera_;
  VoxelProjection projection_;
  VisibilityMap& map_;
  SeenPixels* seen_;
  int columns_apart_;
  std::vector<int32_t> rows_;  // what boxes_ points to
  kernels::Boxes boxes_;       // of the column that is painted
};

// What a camera sees, and of which pixels. Kept to be painted over: most of their time is that of fresh memory.
struct PaintedView {
  VisibilityMap map;
  SeenPixels seen;
};
using PaintedViews = ScratchPool<PaintedView>;

// Anew, in the memory that is there where it suffices.
template <typename T>
void assign(Plane<T>& plane, int width, int height, T value) {
  plane.width = width;
  plane.height = height;
  plane.samples.assign(static_cast<size_t>(width) * static_cast<size_t>(height), value);
}

// Of a camera that sees nothing yet, and so many of its columns.
void empty_map(const PanoramaGrid& grid, const UprightCamera& camera, const LayersOptions& options, VisibilityMap& map,
               int columns_apart = 1);

// What no surface covers between two that a row shows becomes the farther of the two, which goes on there.
void continue_farther_surfaces(VisibilityMap& map);

// Of a camera's columns, how many a map holds.
inline int columns_of_map(const UprightCamera& camera, int columns_apart) {
  return (camera.width + columns_apart - 1) / columns_apart;
}

}  // namespace ldp::layers
