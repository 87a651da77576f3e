// What is seen all around from the centre of a sweep's arc, traced: the truth of `ldp export --kind panorama, stereo,
// depth` (core/export/around.h), in the same frame.
//
// Equirectangular, the whole sphere: the middle column looks along `heading`, columns run clockwise. Two eyes:
// omnidirectional stereo, every column seen along the tangents of a circle whose diameter is the distance of the eyes.
#pragma once

#include "core/base/job.h"
#include "sim/scene/picture.h"
#include "sim/scene/sweep_path.h"

namespace ldp {

struct Surround {
  RgbImage one_eye;
  RgbImage two_eyes;      // the left one's sphere above the right one's
  Plane<float> distance;  // of one eye, metres along each ray; infinity = sky
};

struct SurroundOptions {
  int width = 0;           // pixels a turn, even, at least 4
  double heading_rad = 0;  // to the right of the sweep's middle
  double eyes = 0.064;     // their distance, metres
};

// Throws Cancelled.
Surround take_surround(const Scene& scene, const SweepPath& path, const SurroundOptions& surround,
                       const PictureOptions& options, const Job& job);

}  // namespace ldp
