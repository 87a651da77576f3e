// Frames turned upright: rotated by a homography so that the image plane is parallel to the arc's axis n (DESIGN 1,
// idea 1). A vertical line of panorama voxels (fixed theta and depth) then projects to ONE column, with the row affine
// in v.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "gain.h"
#include "geometry.h"
#include "plane.h"

namespace ldp {

// An undistorted upright camera: image plane parallel to n, columns parallel to n, rows running down. A world point p
// with q = p - centre projects to  x = focal (q . right) / (q . forward) + cx,   y = focal (q . -n) / (q . forward) +
// cy.
struct UprightCamera {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();    // horizontal
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();  // horizontal
  double focal = 0, cx = 0, cy = 0;                    // pixels of the upright image
  int width = 0, height = 0;
  int source = 0;  // index of the photograph in its FrameSource, and of the camera
};

// Samples stored column by column: sample (x, y) at columns.at(y, x), i.e. a plane of `height` wide and `width` high,
// so that one image column is contiguous; grey in `columns`, red minus green plus 128 in `tint`. valid_begin/valid_end
// give, per column, the half-open range of rows that lie inside the photograph.
struct UprightFrame {
  UprightCamera camera;
  GreyImage columns, tint;
  std::vector<int16_t> valid_begin, valid_end;
  Gain gain = {1, 1, 1};  // of this photograph to match the others
};

}  // namespace ldp
