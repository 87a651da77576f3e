#include "core/view/camera_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "core/geometry/degrees.h"

namespace ldp {
namespace {

double middle_depth(const LayeredPanorama& panorama) {
  const double w = 0.35 * panorama.grid.w_near + 0.65 * panorama.grid.w_far;
  return w > 0 ? 1 / w : 1e6;
}

// What all cameras of a path share.
struct Stage {
  const Arc& arc;
  double radius, middle_theta, tilt_v, reach, turn_rad;
  Intrinsics intrinsics;
};

Intrinsics make_intrinsics(const LayeredPanorama& panorama, const CameraPathOptions& options) {
  const PanoramaGrid& grid = panorama.grid;
  double view_rad = options.view_rad;
  if (view_rad == 0 && !panorama.cameras.empty()) {
    const Intrinsics& source = panorama.cameras[0].intrinsics;
    view_rad = 2 * std::atan(source.width / (2 * source.fx));
  }
  if (view_rad == 0) view_rad = kTurn / 6;
  double focal = options.width / (2 * std::tan(view_rad / 2));
  // Off the arc near things need rays beyond those of the arc itself: leave an eighth of the rows to spare.
  const double rows = 0.5 * grid.height * grid.v_pitch;
  focal = options.zoom * std::max(focal, options.height / (2 * 0.875 * rows));
  return {options.width, options.height, focal, focal, 0.5 * options.width, 0.5 * options.height};
}

Stage make_stage(const LayeredPanorama& panorama, const CameraPathOptions& options) {
  const PanoramaGrid& grid = panorama.grid;
  const Arc& arc = grid.arc;
  const bool covered = arc.theta_end > arc.theta_begin;
  const double middle = covered ? 0.5 * (arc.theta_begin + arc.theta_end) : grid.theta(0.5 * grid.width);
  return {arc,
          arc.radius > 0 ? arc.radius : 1,
          middle,
          grid.v(0.5 * grid.height) + options.rise,
          options.reach,
          options.turn_rad,
          make_intrinsics(panorama, options)};
}

Camera look(const Stage& stage, const Eigen::Vector3d& centre, const Eigen::Vector3d& direction) {
  Camera camera;
  camera.intrinsics = stage.intrinsics;
  const Eigen::Vector3d forward = Eigen::AngleAxisd(-stage.turn_rad, stage.arc.axis()) * direction.normalized(),
                        right = forward.cross(stage.arc.axis()).normalized();
  camera.pose.world_from_camera << right, forward.cross(right), forward;
  camera.pose.centre = centre;
  return camera;
}

Camera sway(const LayeredPanorama& panorama, const Stage& stage, double phase) {
  const double reach = std::min(0.5, 0.5 * (stage.arc.theta_end - stage.arc.theta_begin)) * stage.radius * stage.reach;
  const Eigen::Vector3d ahead = stage.arc.outward(stage.middle_theta);
  const Eigen::Vector3d side = ahead.cross(stage.arc.axis());
  const Eigen::Vector3d base = stage.arc.centre + stage.radius * ahead;
  const Eigen::Vector3d centre = base + std::sin(phase) * reach * side - (1 - std::cos(phase)) * 0.15 * reach * ahead;
  const Eigen::Vector3d target = base + middle_depth(panorama) * (ahead + stage.tilt_v * stage.arc.axis());
  return look(stage, centre, target - centre);
}

Camera walk(const Stage& stage, double share) {
  const Arc& arc = stage.arc;
  const double eased = arc.closed ? share : 0.5 + stage.reach * (share * share * (3 - 2 * share) - 0.5);
  const bool covered = arc.theta_end > arc.theta_begin;
  const double theta = covered ? arc.theta_end + eased * (arc.theta_begin - arc.theta_end) : stage.middle_theta;
  const Eigen::Vector3d ahead = arc.outward(theta);
  return look(stage, arc.centre + stage.radius * ahead, ahead + stage.tilt_v * arc.axis());
}

Camera dolly(const ViewingLimits& limits, const Stage& stage, double phase) {
  const bool limited = limits.outer_radius > limits.inner_radius;
  const double inner = limited ? std::max(0.0, limits.inner_radius) : 0;
  const double outer = limited ? limits.outer_radius : 1.25 * stage.radius;
  const Eigen::Vector3d ahead = stage.arc.outward(stage.middle_theta);
  // A shorter way leads to and fro about the arc, where the photos were taken.
  const double home = std::clamp(stage.radius, inner, outer), wide = 0.5 * (inner + outer);
  const double middle = home + stage.reach * (wide - home);
  const double at = middle + stage.reach * 0.5 * (outer - inner) * std::sin(phase);
  return look(stage, stage.arc.centre + at * ahead, ahead + stage.tilt_v * stage.arc.axis());
}

}  // namespace

void check_camera_path(const CameraPathOptions& options) {
  const auto within = [](const char* field, double value, int low, int high) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    if (!(value >= low && value <= high))
      throw std::runtime_error("camera path: " + std::string(field) + " is " + text + "; must be " +
                               std::to_string(low) + " to " + std::to_string(high));
  };
  within("the number of frames", options.frames, 1, 100000);
  within("width", options.width, 1, 1 << 14);
  within("height", options.height, 1, 1 << 14);
  within("the field of view in radians", options.view_rad, 0, 3);
  within("zoom", options.zoom, 1, 100);
  within("reach", options.reach, 0, 1);
}

std::vector<Camera> camera_path(const LayeredPanorama& panorama, const CameraPathOptions& options) {
  check_camera_path(options);
  const Stage stage = make_stage(panorama, options);
  std::vector<Camera> cameras;
  for (int i = 0; i < options.frames; ++i) {
    const double phase = kTurn * i / options.frames;
    const bool closed_walk = stage.arc.closed || options.frames == 1;
    const double share = closed_walk ? phase / kTurn : static_cast<double>(i) / (options.frames - 1);
    switch (options.kind) {
      case CameraPath::sway:
        cameras.push_back(sway(panorama, stage, phase));
        break;
      case CameraPath::walk:
        cameras.push_back(walk(stage, share));
        break;
      case CameraPath::dolly:
        cameras.push_back(dolly(panorama.limits, stage, phase));
        break;
    }
    cameras.back().name = path_view_name(i);
  }
  return cameras;
}

std::string path_view_name(int index) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%03d", index);
  return name;
}

CameraPath camera_path_from_name(std::string_view name) {
  if (name == "sway") return CameraPath::sway;
  if (name == "walk") return CameraPath::walk;
  if (name == "dolly") return CameraPath::dolly;
  throw std::runtime_error("unknown camera path \"" + std::string(name) + "\"; known: sway, walk, dolly");
}

}  // namespace ldp
