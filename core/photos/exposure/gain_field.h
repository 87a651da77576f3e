// Gains that change slowly from place to place of a picture.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/plane.h"
#include "core/photos/exposure/response_curve.h"

namespace ldp {

// Factors of R, G and B at nodes spread evenly over a picture, bilinear between them: node (i, j) lies at (i + .5) /
// columns of its width and (j + .5) / rows of its height. Beyond the outermost ones they stay the same; where the
// picture wraps the last column is followed by the first one.
struct GainField {
  static constexpr int kOne = 4096;

  Plane<std::array<uint16_t, 3>> nodes;  // 1 / kOne, above 0; empty = no factor anywhere
  bool wraps = false;

  bool empty() const { return nodes.empty(); }
  // At shares of the width and height, 0 .. 1. The field must not be empty. The same on every machine.
  std::array<double, 3> at(double x_share, double y_share) const;

  friend bool operator==(const GainField&, const GainField&) = default;
};

// Local exposure (local_exposure.h): factors of light, and the camera's response, by which light becomes levels.
struct DisplayExposure {
  GainField factors;
  ResponseCurve response;  // empty as the factors are

  bool empty() const { return factors.empty(); }
  friend bool operator==(const DisplayExposure&, const DisplayExposure&) = default;
};

}  // namespace ldp
