// What tests of layers look at: a far wall, in front of it a square, and what cameras see of the two.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/layers/layers.h"
#include "tests/unit/simple_capture.h"

namespace ldp::test {

constexpr uint16_t kNearSteps = kDisparitySteps;  // w = 0.5 in these tests: 2 from the circle
constexpr int kFirst = 45, kEnd = 55;             // columns of the near square

// A far wall at infinity, in front of it a square.
inline DisparityMap square_before_the_sky(const PanoramaGrid& grid) {
  DisparityMap map(grid.width, grid.height, 0);
  for (int y = 20; y < 40; ++y)
    for (int x = kFirst; x < kEnd; ++x) map.at(x, y) = kNearSteps;
  return map;
}

// All round, with its seam so many columns to the left of where the cameras look; the square stays before them.
inline PanoramaGrid closed_grid(int seam) {
  PanoramaGrid grid = simple_grid(0.5);
  grid.width = 640;
  grid.theta_pitch = 2 * std::numbers::pi / grid.width;
  grid.theta_left = seam * grid.theta_pitch;
  grid.wraps = true;
  return grid;
}

inline std::vector<UprightFrame> three_cameras() {
  return {upright_of(camera_at(0.25), 0), upright_of(camera_at(0), 1), upright_of(camera_at(-0.25), 2)};
}

inline std::vector<VisibilityMap> visibility(const PanoramaGrid& grid, const std::vector<const DisparityMap*>& layers,
                                             const std::vector<UprightFrame>& frames, const LayersOptions& options,
                                             const Job& job) {
  std::vector<VisibilityMap> maps;
  for (const DisparityMap* layer : layers) add_layer(grid, *layer, frames, options, job, maps);
  return maps;
}

// Moved to the right by so many columns, round the seam.
template <typename Sample>
Plane<Sample> rotated(const Plane<Sample>& map, int columns) {
  Plane<Sample> result = map;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) result.at((x + columns) % map.width, y) = map.at(x, y);
  return result;
}

// What camera `index` at `angle` of the circle sees: grey(its centre, the direction of a ray).
template <typename Grey>
UprightFrame photograph(double angle, int index, const Grey& grey) {
  const Camera camera = camera_at(angle);
  UprightFrame frame = upright_of(camera, index);
  for (int y = 0; y < camera.intrinsics.height; ++y)
    for (int x = 0; x < camera.intrinsics.width; ++x) {
      const Eigen::Vector3d ray = camera.pose.world_from_camera * unproject(camera.intrinsics, {x + 0.5, y + 0.5});
      frame.columns.at(y, x) = static_cast<uint8_t>(std::lround(grey(camera.pose.centre, ray)));
    }
  return frame;
}

enum class Plain { nothing, square, all };

// What cameras see of square_before_the_sky: two patterns, or one or none.
inline std::vector<UprightFrame> photographs_of_the_square(const PanoramaGrid& grid, Plain plain) {
  const DisparityMap truth = square_before_the_sky(grid);
  const auto column = [&](double theta) { return (grid.theta_left - theta) / grid.theta_pitch; };
  const auto row = [&](double v) { return (grid.v_top - v) / grid.v_pitch; };
  const auto grey = [&](const Eigen::Vector3d& centre, const Eigen::Vector3d& direction) -> double {
    if (plain == Plain::all) return 90;
    const double depth = 1 / grid.w_near, radius = grid.arc.radius + depth;
    const double a = direction.x() * direction.x() + direction.y() * direction.y();
    const double b = direction.x() * centre.x() + direction.y() * centre.y();
    const double c = centre.x() * centre.x() + centre.y() * centre.y() - radius * radius;
    const Eigen::Vector3d p = centre + direction * ((-b + std::sqrt(b * b - a * c)) / a);
    const double x = column(std::atan2(p.y(), p.x())), y = row(p.z() / depth);
    if (truth.contains(static_cast<int>(x), static_cast<int>(y)) &&
        truth.at(static_cast<int>(x), static_cast<int>(y)) == kNearSteps)
      return plain == Plain::square ? 120 : 120 + 50 * std::sin(1.1 * x) + 50 * std::cos(0.9 * y);
    const double far_x = column(std::atan2(direction.y(), direction.x())), far_y = row(direction.z() / std::sqrt(a));
    return 130 + 60 * std::sin(0.8 * far_x + 0.5 * far_y) + 50 * std::cos(0.6 * far_y - 1.3 * far_x);
  };
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(photograph(0.3 - 0.15 * i, i, grey));
  return frames;
}

inline DisparityMap fattened_square(const PanoramaGrid& grid, int by_px) {
  DisparityMap map = square_before_the_sky(grid);
  for (int y = 20 - by_px; y < 40 + by_px; ++y)
    for (int x = kFirst - by_px; x < kEnd + by_px; ++x) map.at(x, y) = kNearSteps;
  return map;
}

inline int differing(const DisparityMap& a, const DisparityMap& b) {
  int count = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) count += a.samples[i] != b.samples[i];
  return count;
}

}  // namespace ldp::test
