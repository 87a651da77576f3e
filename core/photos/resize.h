// Scales a picture down by averaging the area that each new pixel covers.
#pragma once

#include "core/base/plane.h"

namespace ldp {

// Width and height at most those of the source (throws std::logic_error otherwise). Rounded from exact means.
RgbImage resize_by_area(const RgbImage& source, int width, int height);
GreyImage resize_by_area(const GreyImage& source, int width, int height);

}  // namespace ldp
