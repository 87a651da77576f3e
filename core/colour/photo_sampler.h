// The colour that one photograph shows of a voxel.
#pragma once

#include <array>
#include <vector>

#include "geometry.h"
#include "plane.h"
#include "voxel_projection.h"

namespace ldp {

using Colour = std::array<int, 3>;  // 0 .. 255 * kColourSteps a channel; gains may lift it above

constexpr int kColourSteps = 16;

// Projects with the photograph's own camera, distortion included, and interpolates (Catmull-Rom in integer weights).
// Where panorama pixels are larger than the photograph's, several samples spread over the pixel are averaged.
class PhotoSampler {
 public:
  PhotoSampler(const PanoramaGrid& grid, const Camera& camera, const std::array<float, 3>& gain);

  // Of pixel (x, y) at inverse depth w. The voxel must lie in front of the camera.
  Colour sample(const RgbImage& photo, int x, int y, double w) const;

 private:
  Eigen::Vector2d position(Heading u, double v, double w) const;

  const PanoramaGrid& grid_;
  Intrinsics intrinsics_;
  std::array<double, 9> camera_from_arc_;
  std::array<double, 3> offset_;   // arc centre minus camera centre, camera axes
  std::array<int, 3> gain_;        // in 1/4096
  int taps_;                       // samples a side of a panorama pixel
  std::vector<Heading> headings_;  // of every sample along the panorama's width
};

}  // namespace ldp
