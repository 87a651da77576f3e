// A view's transform of panorama rays into its image, in tables, and the culling of what lies outside.
//
// The point of ray (theta, v) at inverse depth w, seen from a camera at c with axes R, is up to the positive factor w
//   q = A(theta) + v N + w B(theta),  A = R^T u(theta),  N = R^T n,  B = R^T (C - c + r u(theta)),
// which stays finite at w = 0. It projects by q.x / q.z, q.y / q.z, and w / q.z is its inverse z-depth.
#pragma once

#include <cstdint>
#include <vector>

#include "core/panorama/panorama.h"
#include "core/view/mesh/mesh.h"
#include "core/view/raster/raster_kernels.h"

namespace ldp::view {

using kernels::ScreenRow;

// A part of the image in normalised, undistorted coordinates.
struct Window {
  float x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

// What the cells of a tile may cover: screen positions as in ScreenRow but in whole pixels, and the largest inverse z.
// Cells without quads cover nothing: x1 < x0. Of cells too near the camera's plane nothing is known: they may cover
// everything.
struct CellBounds {
  float x0[kCells], x1[kCells], y0[kCells], y1[kCells], nearest[kCells];
};

class ViewFrustum {
 public:
  // Vertices stand in rows first_row .. first_row + rows - 1 of the panorama.
  ViewFrustum(const PanoramaGrid& grid, int first_row, int rows, const Camera& camera);

  Window window(int column_begin, int column_end) const;
  bool sees(const MeshTile& tile, const Window& window) const;

  CellBounds bounds(const MeshTile& tile) const;  // without distortion only
  bool distorts() const { return lens_.distorts; }

  // Positions of `count` vertices of row y from column x on, out[first] being the first; w from there on.
  void project_row(int x, int y, int count, const float* w, int first, ScreenRow& out) const;

  // The same, to the same bits, of up to kTilePx + 1 vertices anywhere; out[0] is the first.
  void project_scattered(int count, const int* x, const int* y, const float* w, ScreenRow& out) const;

 private:
  const kernels::Kernels& kernels_ = kernels::best();
  Intrinsics intrinsics_;
  int last_column_;
  kernels::Lens lens_{};
  // Columns 0 .. width, with room for whole tiles; column width is column 0 again when the panorama wraps.
  std::vector<float> ax_, ay_, az_, bx_, by_, bz_, b_length_, v_;
  float nx_ = 0, ny_ = 0, nz_ = 0;
  float bulge_ = 0, cell_bulge_ = 0;  // how far an arc of a tile's, of a cell's width rises over its chord, in radii
};

}  // namespace ldp::view
