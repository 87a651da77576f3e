// Turns photographs upright and even in exposure, once, for the sweep (core/photos/upright_frame.h says why).
//
// Takes frames, their cameras, the arc; gives UprightFrames (grey and tint, column-major) and gains. Colours are
// read later, from the photographs themselves.
//
// How: the upright camera keeps the photo's centre and, divided by the pitch, its focal length; its image spans the
// photo's outline, but at most rectification::kMaxUprightTangent either side of its axis. Samples are Catmull-Rom
// interpolated at positions rounded to 1/256 pixel, lens distortion included; integer from photo to sample. Slow
// shading is taken out first (background_subtraction.h). Gains (exposure_compensation.h; exposure_gain.h) are one per
// frame and channel; where they differ much, samples are those of local exposure (local_exposure.h). Photographs are
// worked on in parallel, as many as fit 32 MiB; each is decoded twice (exposure first, then samples).
#pragma once

#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/geometry/geometry.h"
#include "core/photos/exposure/calibration.h"
#include "core/photos/frame_source.h"
#include "core/photos/upright_frame.h"

namespace ldp {

// cameras[i] belongs to frames.load(frame_of_camera[i]). An upright pixel spans `pitch_px` of the photo's: with those
// of a coarse panorama nothing is lost and memory is saved. Throws std::runtime_error naming the photo when its size
// does not match its camera or where looks_straight_up_or_down. `local` gets by which light photographs differ where
// samples are those of local exposure, and nothing where they are not.
std::vector<UprightFrame> rectify(const FrameSource& frames, const std::vector<Camera>& cameras,
                                  const std::vector<int>& frame_of_camera, const std::vector<ScenePoint>& points,
                                  const Arc& arc, double pitch_px, const Job& job,
                                  std::optional<Calibration>* local = nullptr);

// Whether the camera cannot be turned upright: its line of sight is within 12 degrees of the arc's axis.
bool looks_straight_up_or_down(const Camera& camera, const Arc& arc);

// Of all upright frames together.
size_t upright_pixels(const std::vector<Camera>& cameras, const Arc& arc, double pitch_px);

}  // namespace ldp
