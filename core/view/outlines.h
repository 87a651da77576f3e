// Outlines of surfaces in a view, as soft as a lens and a sensor show them.
//
// A z-buffer gives each pixel to one surface: outlines are stairs, which crawl as the eye moves, and every pixel that a
// photograph mixed stands on one side of them. So pixels at steps of depth show a weighted mean of the 3x3 around
// them, and specks of a pixel or two what is around them. Depths stay those of the surfaces drawn.
#pragma once

#include "core/base/job.h"
#include "core/base/plane.h"

namespace ldp::view {

// inverse_z: of every pixel, negative where there is nothing [1 / unit of depth]; least_step: what is a step of depth,
// at least, in the same unit.

// Holes of a pixel's width show the farthest surface beside them.
void close_cracks(float least_step, Plane<float>& inverse_z, RgbImage& colour, Plane<uint8_t>& alpha);

// Holes stay as they are, and so do the pixels at the picture's edge.
void soften_outlines(float least_step, const Plane<float>& inverse_z, const Plane<uint8_t>& alpha, const Job& job,
                     RgbImage& colour);

}  // namespace ldp::view
