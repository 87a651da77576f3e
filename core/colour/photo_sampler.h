// The colour that one photograph shows of a voxel.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "core/geometry/voxel_projection.h"
#include "core/photos/exposure_gain.h"

namespace ldp::colour {

using Colour = std::array<int, 3>;  // 0 .. 255 * kColourSteps a channel; beyond with gains, and as a difference

constexpr int kColourSteps = 16;

// Projects with the photograph's own camera, distortion included, and interpolates (Catmull-Rom in integer weights).
// Where panorama pixels are larger than the photograph's, several samples spread over the pixel are averaged.
class PhotoSampler {
 public:
  PhotoSampler(const PanoramaGrid& grid, const Camera& camera, const Gain& gain);

  // Of pixel (x, y) at inverse depth w. The voxel must lie in front of the camera.
  Colour sample(const RgbImage& photo, int x, int y, double w) const;

  // Of one whose middle may lie behind the camera or outside its picture: nothing then.
  std::optional<Colour> sample_if_inside(const RgbImage& photo, int x, int y, double w) const;

 private:
  Colour mean(const Colour& sum, int count) const;  // with the photograph's gain

  const PanoramaGrid& grid_;
  Intrinsics intrinsics_;
  PhotoProjection projection_;
  ExposureGain gain_;
  int taps_;                       // samples a side of a panorama pixel
  std::vector<Heading> headings_;  // of every sample along the panorama's width
};

}  // namespace ldp::colour
