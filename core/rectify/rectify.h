// Turns photographs upright and even in exposure, once, for the sweep (DESIGN 1, idea 1).
//
// Takes frames, their cameras, the arc; gives UprightFrames (grey and tint, column-major) and gains. Colour is fetched
// later, frame by frame, through `upright_colour`.
//
// How: the upright camera keeps the photo's centre and focal length; its image spans the photo's outline, but at most
// kMaxUprightTangent either side of its axis. Samples are Catmull-Rom interpolated at positions rounded to 1/256 pixel,
// lens distortion included; integer from photo to sample. Slow shading is taken out first (flatten.h). Gains
// (exposure.h) are one factor per frame and channel. Photographs are worked on in parallel, as many as fit 32 MiB;
// each is decoded twice (exposure first, then samples).
#pragma once

#include <vector>

#include "frames.h"
#include "geometry.h"
#include "job.h"
#include "upright.h"

namespace ldp {

constexpr double kMaxUprightTangent = 2.0;  // 63 degrees off the upright axis; beyond, a photo is cut

// cameras[i] belongs to frames.load(frame_of_camera[i]). Throws std::runtime_error naming the photo when its size does
// not match its camera or when it looks straight up or down.
std::vector<UprightFrame> rectify(const FrameSource& frames, const std::vector<Camera>& cameras,
                                  const std::vector<int>& frame_of_camera, const std::vector<ScenePoint>& points,
                                  const Arc& arc, const Job& job);

// The same photograph in colour, upright, gain applied, row-major; same geometry as the UprightFrame. Samples outside
// the photograph repeat its border.
RgbImage upright_colour(const FrameSource& frames, const Camera& camera, const UprightFrame& frame);

}  // namespace ldp
