// Where the samples of an upright image lie in its photograph, and their interpolation in integers.
#pragma once

#include <cstdint>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "core/photos/upright_frame.h"

namespace ldp::rectification {

// Whether the camera looks along the axis: its image plane cannot be turned parallel to it.
bool is_along(const Camera& camera, const Eigen::Vector3d& axis);

// The upright camera of a photograph: same centre, image plane parallel to `axis`, just large enough; one of its pixels
// spans `pitch_px` of the photograph's.
UprightCamera upright_camera(const Camera& camera, const Eigen::Vector3d& axis, int source, double pitch_px);

// A position in the photograph in 1/256 pixel, relative to the centre of its first pixel.
struct SourcePosition {
  int x_q8 = 0, y_q8 = 0;
  bool inside = false;  // on or between pixel centres; otherwise x and y are clamped to them
};

// Maps positions along one upright column to the photograph. Columns and rows count from the centre of the first pixel.
class ColumnMap {
 public:
  ColumnMap(const Camera& camera, const UprightCamera& upright, double column);
  SourcePosition at(double row) const;

 private:
  const Intrinsics& intrinsics_;
  Eigen::Vector3d first_, step_;  // direction of row 0 in camera axes, and its change per row
};

constexpr int kSampleScale = 64;

// Catmull-Rom interpolation at one position of planes of kSampleScale times 8-bit values; clamped to 0..255. Borders
// repeat.
class Interpolation {
 public:
  explicit Interpolation(const SourcePosition& position);
  uint8_t operator()(const Plane<uint16_t>& plane) const;

 private:
  static constexpr int kTaps = 4 * 4;
  int x0_, y0_;  // of the first tap
  int16_t weights_[kTaps];
};

}  // namespace ldp::rectification
