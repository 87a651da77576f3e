#include "sim/scene/sweep_path.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "core/geometry/degrees.h"
#include "sim/scene/random.h"

namespace ldp {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

std::string numbered(int index) {
  char name[24];
  std::snprintf(name, sizeof name, "%03d.png", index);
  return name;
}

Intrinsics intrinsics_of(const SweepPath& path) {
  Intrinsics in;
  in.width = path.width;
  in.height = path.height;
  in.fx = in.fy = 0.5 * path.width / std::tan(0.5 * path.fov_rad);
  in.cx = 0.5 * path.width;
  in.cy = 0.5 * path.height;
  in.k1 = path.k1;
  return in;
}

// Camera that looks along the outward direction at `theta`.
Pose outward_pose(const Vector3d& centre, double theta) {
  const Vector3d forward{std::cos(theta), std::sin(theta), 0}, down{0, 0, -1};
  Pose pose;
  pose.world_from_camera << down.cross(forward), down, forward;
  pose.centre = centre;
  return pose;
}

bool closed(const SweepPath& path) { return path.arc_rad > kTurn - 1e-6; }

// Angle at a share of the sweep, 0 .. 1.
double theta_at(const SweepPath& path, double share) { return 0.5 * std::numbers::pi + path.arc_rad * (0.5 - share); }

Vector3d on_circle(const SweepPath& path, double theta, double radius) {
  return {radius * std::cos(theta), radius * std::sin(theta), path.eye_height};
}

}  // namespace

std::vector<Camera> sweep_cameras(const SweepPath& path) {
  if (path.frames < 1) throw std::logic_error("sweep_cameras: frames must be at least 1");
  Random random(mix_bits(path.seed) + 1);
  const int steps = closed(path) ? path.frames : path.frames - 1;
  std::vector<Camera> cameras;
  for (int i = 0; i < path.frames; ++i) {
    const double theta = theta_at(path, steps == 0 ? 0.5 : static_cast<double>(i) / steps);
    const Vector3d slip{random.normal(), random.normal(), random.normal()};
    Pose pose = outward_pose(on_circle(path, theta, path.radius) + path.position_jitter * slip, theta);
    const double yaw = random.normal(), pitch = random.normal(), roll = random.normal();
    pose.world_from_camera = pose.world_from_camera * (AngleAxisd(path.angle_jitter_rad * yaw, Vector3d::UnitY()) *
                                                       AngleAxisd(path.angle_jitter_rad * pitch, Vector3d::UnitX()) *
                                                       AngleAxisd(path.angle_jitter_rad * roll, Vector3d::UnitZ()))
                                                          .toRotationMatrix();
    cameras.push_back({numbered(i), intrinsics_of(path), pose});
  }
  return cameras;
}

std::vector<Camera> novel_cameras(const SweepPath& path) {
  struct NovelView {
    double share, radius_factor, raise_m, turn_deg;
  };
  constexpr NovelView kViews[] = {{0.12, 1, 0, 0},   {0.37, 1, 0, 0},    {0.63, 1, 0, 0},  {0.88, 1, 0, 0},
                                  {0.3, 0.7, 0, 0},  {0.5, 0.4, 0, 0},   {0.7, 0.7, 0, 0}, {0.45, 1.15, 0, 0},
                                  {0.35, 1, 0.1, 0}, {0.65, 1, -0.1, 0}, {0.4, 1, 0, 12},  {0.6, 1, 0, -12}};
  std::vector<Camera> cameras;
  for (const NovelView& view : kViews) {
    const double theta = theta_at(path, view.share);
    const Vector3d centre = on_circle(path, theta, view.radius_factor * path.radius) + Vector3d(0, 0, view.raise_m);
    const Pose pose = outward_pose(centre, theta + view.turn_deg * std::numbers::pi / 180);
    cameras.push_back({numbered(static_cast<int>(cameras.size())), intrinsics_of(path), pose});
  }
  return cameras;
}

}  // namespace ldp
