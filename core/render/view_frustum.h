// A view's transform of panorama rays into its image, in tables, and the culling of what lies outside.
//
// The point of ray (theta, v) at inverse depth w, seen from a camera at c with axes R, is up to the positive factor w
//   q = A(theta) + v N + w B(theta),  A = R^T u(theta),  N = R^T n,  B = R^T (C - c + r u(theta)),
// which stays finite at w = 0. It projects by q.x / q.z, q.y / q.z, and w / q.z is its inverse z-depth.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "mesh.h"
#include "panorama.h"

namespace ldp::render {

constexpr int kSubPx = 256;  // screen positions are integers in 1/256 pixel; pixel centres are multiples of it
constexpr int32_t kOffScreen = std::numeric_limits<int32_t>::min();  // x of a vertex behind the camera or far outside

// Vertices of one tile row.
struct ScreenRow {
  int32_t x[kTilePx + 1], y[kTilePx + 1];
  float inverse_z[kTilePx + 1];
};

// A part of the image in normalised, undistorted coordinates.
struct Window {
  float x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

class ViewFrustum {
 public:
  ViewFrustum(const PanoramaGrid& grid, const Camera& camera);

  Window window(int column_begin, int column_end) const;
  bool sees(const MeshTile& tile, const Window& window) const;

  // Positions of `count` vertices of row y from column x on; at most kTilePx + 1.
  void project_row(int x, int y, int count, const float* w, ScreenRow& out) const;

  // The same, to the same bits, for vertices anywhere.
  void project_scattered(int count, const int* x, const int* y, const float* w, ScreenRow& out) const;

 private:
  // Vertices as q = base + w * slope.
  struct Lanes {
    float base_x[kTilePx + 1], base_y[kTilePx + 1], base_z[kTilePx + 1];
  };
  void project(int count, const Lanes& base, const float* bx, const float* by, const float* bz, const float* w,
               ScreenRow& out) const;
  void distort(int count, float* x, float* y, float* in_front) const;
  void to_screen(int count, const float* nx, const float* ny, const float* in_front, ScreenRow& out) const;

  Intrinsics intrinsics_;
  bool distorted_ = false;
  float max_r2_ = 0;  // beyond this radius the distortion folds back
  // Columns 0 .. width; column width is column 0 again when the panorama wraps.
  std::vector<float> ax_, ay_, az_, bx_, by_, bz_, b_length_, v_;
  float nx_ = 0, ny_ = 0, nz_ = 0;
  float bulge_ = 0;  // how far an arc of a tile's width rises over its chord, in radii
};

}  // namespace ldp::render
