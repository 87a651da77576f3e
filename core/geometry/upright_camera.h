// A camera turned upright: its image plane is parallel to the arc's axis n.
#pragma once

#include <Eigen/Core>

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

}  // namespace ldp
