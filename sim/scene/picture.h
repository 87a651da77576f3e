// Photographs of a synthetic scene: anti-aliased colour and exact z-depth, for any camera, distortion included.
//
// Takes a scene and a camera; gives sRGB colour and the z-depth at every pixel's centre (infinity = sky). Colour is
// averaged in linear light over the pixel's centre and corners, and over 3x3 samples wherever those disagree.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "sim/scene/scene.h"

namespace ldp {

struct PictureOptions {
  int edge_samples = 3;       // per axis, in pixels with an edge (1 .. 8); smooth pixels take the centre and corners
  double exposure = 1;        // multiplies linear light
  bool meters = false;        // automatic exposure: and what brings the picture's mean (of logarithms) to mid-grey
  double noise = 0;           // deviation of the sensor's noise at mid-grey, in 8-bit levels
  double motion_blur_px = 0;  // length of a horizontal smear
  uint64_t noise_seed = 0;
};

struct Picture {
  RgbImage colour;
  Plane<float> depth;
  double exposure = 1;  // with what was metered
};

Picture take_picture(const Scene& scene, const Camera& camera, const PictureOptions& options, const Job& job);

// The ray of a position in a picture that no lens takes; called from several threads. Depth is its t.
using RayOf = std::function<Ray(const Eigen::Vector2d& position_px)>;
Picture take_picture(const Scene& scene, int width, int height, const RayOf& ray_of, const PictureOptions& options,
                     const Job& job);

// The colour of linear light in a picture taken without noise.
Rgb developed(const Eigen::Vector3f& light);

// The exact z-depth alone.
Plane<float> take_depth(const Scene& scene, const Camera& camera, const Job& job);

}  // namespace ldp
