// Turns photographs upright and even in exposure, once, for the sweep (DESIGN 1, idea 1).
//
// Takes frames, their cameras, the arc; gives UprightFrames (grey, column-major) and gains. Colour is fetched later,
// frame by frame, through `upright_colour`.
#pragma once

#include <vector>

#include "frames.h"
#include "geometry.h"
#include "job.h"
#include "upright.h"

namespace ldp {

// cameras[i] belongs to frames.load(frame_of_camera[i]).
std::vector<UprightFrame> rectify(const FrameSource& frames, const std::vector<Camera>& cameras, const std::vector<int>& frame_of_camera,
                                  const std::vector<ScenePoint>& points, const Arc& arc, const Job& job);

// The same photograph in colour, upright, gain applied, row-major; same geometry as the UprightFrame.
RgbImage upright_colour(const FrameSource& frames, const Camera& camera, const UprightFrame& frame);

}  // namespace ldp
