// Draws layers into what one camera sees first: every pixel of a layer is a rectangle that shares its sides with
// neighbours on the same surface.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/geometry/same_surface.h"
#include "core/geometry/voxel_projection.h"
#include "core/layers/layers.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {

// What painting a layer into any camera's map needs.
struct Brush {
  const PanoramaGrid& grid;
  std::vector<Heading> edges;
  std::vector<double> edges_v;
  std::vector<double> inverse_depths;  // of half disparity steps
  Plane<uint16_t> columns;             // the layer's

  Brush(const PanoramaGrid& on, const DisparityMap& layer);
};

// Names of the panorama's pixels, to be painted along with their depths: `of` like Brush::columns, `seen` like the map.
struct Names {
  const Plane<uint16_t>& of;
  Plane<uint16_t>& seen;
};

class MapPainter {
 public:
  // `names` may be null.
  MapPainter(const Brush& brush, const UprightCamera& camera, const LayersOptions& options, VisibilityMap& map,
             const Names* names = nullptr);

  // One column of the layer.
  void paint(int x);

 private:
  struct Sides {  // of a column
    VoxelProjection::Column left, right;
  };

  int shared_edge(int d, int neighbour) const;
  bool in_view(Heading h) const;
  bool beside_view(const Sides& sides) const;
  void paint_pixel(const Sides& sides, int x, int y, int left_half_steps, int d, int right_half_steps);

  const PanoramaGrid& grid_;
  const Brush& brush_;
  VoxelProjection projection_;
  SurfaceTolerance<double> connected_;  // in disparity steps
  VisibilityMap& map_;
  const Names* names_;
};

VisibilityMap empty_map(const PanoramaGrid& grid, const UprightCamera& camera, const LayersOptions& options);

}  // namespace ldp::layers
