// Cameras that move smoothly through a panorama, for short films that let parallax be seen.
//
// Takes a panorama's arc and viewing limits; gives upright cameras without distortion, named "frame_000" and on, whose
// view stays inside the panorama's rows. sway and dolly end where they begin, and so does walk on a closed arc.
#pragma once

#include <string_view>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/panorama/panorama.h"

namespace ldp {

enum class CameraPath {
  sway,   // on a flat ellipse about the middle of the arc, turned to what lies at middle depth
  walk,   // along the arc from end to end, looking outwards
  dolly,  // into the circle and out beyond the arc, looking outwards from its middle
};

struct CameraPathOptions {
  CameraPath kind = CameraPath::sway;
  int frames = 90;  // 1 .. 100000
  int width = 800, height = 600;
  double view_rad = 0;  // horizontal field of view; 0: that of the first source camera, or 60 degrees
  // How the path is framed (framing.h): focal length in parts of what view_rad tells, from 1; share of the way from its
  // middle, 0 .. 1; all views turned clockwise [rad] and raised, as a slope.
  double zoom = 1, reach = 1, turn_rad = 0, rise = 0;
};

// Throws std::runtime_error naming what is out of its range.
void check_camera_path(const CameraPathOptions& options);

std::vector<Camera> camera_path(const LayeredPanorama& panorama, const CameraPathOptions& options);

// Of each of its views: "frame_007".
std::string path_view_name(int index);

// "sway", "walk" or "dolly"; throws std::runtime_error naming them otherwise.
CameraPath camera_path_from_name(std::string_view name);

}  // namespace ldp
