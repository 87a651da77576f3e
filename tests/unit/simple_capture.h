// A capture small enough to reason about: a grid over one radian, upright cameras on a circle of radius 1 looking out.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"
#include "core/photos/upright_frame.h"

namespace ldp::test {

constexpr int kFocal = 100;

inline PanoramaGrid simple_grid(double w_near) {
  PanoramaGrid grid;
  grid.arc.radius = 1;
  grid.width = 100, grid.height = 60;
  grid.theta_pitch = grid.v_pitch = 1.0 / kFocal;
  grid.theta_left = 0.5, grid.v_top = 0.3;
  grid.w_near = w_near;
  return grid;
}

// Looks along u(theta) from (1, theta); its image is a little larger than the grid.
inline Camera camera_at(double theta) {
  Camera camera;
  camera.intrinsics = {140, 80, kFocal, kFocal, 70, 40, 0, 0, 0, 0};
  camera.pose.centre = {std::cos(theta), std::sin(theta), 0};
  camera.pose.world_from_camera.col(0) = Eigen::Vector3d(std::sin(theta), -std::cos(theta), 0);
  camera.pose.world_from_camera.col(1) = Eigen::Vector3d(0, 0, -1);
  camera.pose.world_from_camera.col(2) = Eigen::Vector3d(std::cos(theta), std::sin(theta), 0);
  return camera;
}

inline UprightFrame upright_of(const Camera& camera, int source) {
  UprightFrame frame;
  const Intrinsics& k = camera.intrinsics;
  frame.camera = {camera.pose.centre,
                  camera.pose.world_from_camera.col(0),
                  camera.pose.world_from_camera.col(2),
                  k.fx,
                  k.cx,
                  k.cy,
                  k.width,
                  k.height,
                  source};
  frame.columns = frame.tint = GreyImage(k.height, k.width);
  frame.valid_begin.assign(static_cast<size_t>(k.width), 0);
  frame.valid_end.assign(static_cast<size_t>(k.width), static_cast<int16_t>(k.height));
  return frame;
}

class FramesInMemory final : public FrameSource {
 public:
  explicit FramesInMemory(std::vector<RgbImage> images) : images_(std::move(images)) {}
  int size() const override { return static_cast<int>(images_.size()); }
  std::string name(int index) const override { return "frame_" + std::to_string(index); }
  RgbImage load(int index) const override { return images_[static_cast<size_t>(index)]; }
  std::optional<double> focal_hint(int) const override { return std::nullopt; }

 private:
  std::vector<RgbImage> images_;
};

}  // namespace ldp::test
