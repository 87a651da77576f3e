// Full resolution of colour where a codec keeps half of it (4:2:0): where the difference of a channel from luma changes
// with luma from one 2 x 2 pixels to the next, it is taken to change so from pixel to pixel, too (FORMAT.md, section 7;
// the linear model of the guided image filter, He, Sun and Tang, 2010). Integers only. Images have even sides, as
// packed ones do.
#pragma once

#include "core/panorama/panorama.h"

namespace ldp::file {

// What the codec gave, guided by its luma, which stays as it is but for rounding.
RgbImage guide_colour(const RgbImage& decoded);

// The image to code so that what comes out, guided, is close to the given one.
RgbImage made_for_guiding(const RgbImage& image);

}  // namespace ldp::file
