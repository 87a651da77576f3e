// The exposure at which a photograph takes part: one gain for all of its pixels, or factors of light by direction.
#pragma once

#include <array>

#include "core/base/plane.h"
#include "core/photos/exposure/gain_field.h"
#include "core/photos/exposure_gain.h"

namespace ldp {

class PhotoExposure {
 public:
  explicit PhotoExposure(const Gain& gain) : gain_(gain) {}
  PhotoExposure(DisplayExposure over_photo, int width, int height);  // of so many pixels

  // Of a colour in 0 .. 255 * units at a pixel; a channel other than the largest may come to lie above.
  std::array<int, 3> operator()(const std::array<int, 3>& colour, int units, int x, int y) const;

  // The whole photograph, rounded to levels.
  void apply(RgbImage& photo) const;

 private:
  ExposureGain gain_;
  DisplayExposure over_photo_;  // empty: the gain
  int width_ = 0, height_ = 0;
};

}  // namespace ldp
