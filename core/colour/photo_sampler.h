// The colour that one photograph shows of a voxel.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "core/geometry/voxel_projection.h"
#include "core/photos/exposure/gain_field.h"
#include "core/photos/exposure_gain.h"

namespace ldp::colour {

using Colour = std::array<int, 3>;  // 0 .. 255 * kColourSteps a channel; beyond with gains, and as a difference

constexpr int kColourSteps = 16;

// Projects with the photograph's own camera, distortion included, and interpolates (Catmull-Rom in integer weights).
// Where panorama pixels are larger than the photograph's, several samples spread over the pixel are averaged.
class PhotoSampler {
 public:
  // The photograph's gain; of light where there is local exposure over the panorama, which must outlive this.
  PhotoSampler(const PanoramaGrid& grid, const Camera& camera, const Gain& gain,
               const DisplayExposure* local = nullptr);

  // Of pixel (x, y) at inverse depth w. The voxel must lie in front of the camera.
  Colour sample(const RgbImage& photo, int x, int y, double w) const;

  // How little the photograph tells of the middle of pixel (x, y), 0 .. 1: where it took more light than is shown, what
  // it has near white may be cut off. 0 without local exposure.
  double distrust(const RgbImage& photo, int x, int y, double w) const;

  // Of one whose middle may lie behind the camera or outside its picture, or is not to be trusted: nothing then.
  std::optional<Colour> sample_if_inside(const RgbImage& photo, int x, int y, double w) const;

 private:
  Colour mean(const Colour& sum, int count, int x, int y) const;  // with the gain at pixel (x, y)
  Colour exposed(const Colour& colour, int units, int x, int y) const;
  std::array<double, 3> factor_at(int x, int y) const;  // of light, where there is local exposure
  double distrust(const Colour& colour, int x, int y) const;

  const PanoramaGrid& grid_;
  Intrinsics intrinsics_;
  PhotoProjection projection_;
  Gain gain_;
  ExposureGain everywhere_;  // the same, where there is no local exposure
  const DisplayExposure* local_;
  int taps_;                       // samples a side of a panorama pixel
  std::vector<Heading> headings_;  // of every sample along the panorama's width
};

}  // namespace ldp::colour
