// Where a synthetic photographer holds the camera: the sweep along the arm's arc, and the novel views it is judged by.
//
// World: z up, the arc around (0, 0, eye_height). Frames run clockwise seen from above (the photographer turns right),
// symmetric about the +y axis. Camera axes as in geometry.h.
#pragma once

#include <vector>

#include "core/geometry/geometry.h"

namespace ldp {

struct SweepPath {
  int frames = 20;
  double arc_rad =
      3.14159265358979;      // between the first and the last frame; a full turn closes without repeating a frame
  double radius = 0.65;      // arm length, metres
  double fov_rad = 1.01229;  // horizontal
  int width = 800, height = 600;
  double k1 = 0;                     // radial distortion of the lens
  double position_jitter = 0.015;    // deviation of the hand, metres (each axis)
  double angle_jitter_rad = 0.0209;  // deviation of the hand, about each axis
  double eye_height = 1.6;
  unsigned seed = 1;
};

// Names "000.png", "001.png", ...
std::vector<Camera> sweep_cameras(const SweepPath& path);

// Twelve views without jitter, named like the frames: 0-3 on the arc between frames, 4-6 inside the circle, 7 outside,
// 8-9 above and below, 10-11 turned 12 degrees off the radius.
std::vector<Camera> novel_cameras(const SweepPath& path);

}  // namespace ldp
