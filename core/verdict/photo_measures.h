// What one photograph alone tells of its quality: brightness, blur, noise.
#pragma once

#include "core/base/plane.h"

namespace ldp {

struct PhotoMeasures {
  double brightness = 0;  // mean grey, 0 .. 255
  // Share of the differences between neighbouring pixels in x and in y that another blur would leave, 0 (sharp) .. 1
  // (Crete, Dolmiere, Ladret, Nicolas 2007).
  double blur_x = 0, blur_y = 0;
  double noise = 0;   // deviation of grey, from where the photograph is smoothest, levels of 255 (Immerkaer 1996)
  double detail = 0;  // root of the mean squared difference between neighbouring pixels, levels of 255
};

// Sums of integers: the same on every machine. Photographs of under 16 pixels a side measure 0.
PhotoMeasures measure(const RgbImage& photo);

}  // namespace ldp
