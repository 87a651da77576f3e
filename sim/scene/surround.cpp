#include "sim/scene/surround.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace ldp {
namespace {

constexpr double kPi = std::numbers::pi;

// aside: of the eye, along the right hand of whoever looks at a column. Directions have length 1.
RayOf rays_of(double eye_height, const SurroundOptions& surround, double aside) {
  const double pitch = 2 * kPi / surround.width, left = 3 * kPi / 2 - surround.heading_rad;
  return [=](const Eigen::Vector2d& at) {
    const double theta = left - at.x() * pitch, elevation = kPi / 2 - at.y() * pitch;
    const Eigen::Vector3d forward(std::cos(theta), std::sin(theta), 0), right(std::sin(theta), -std::cos(theta), 0);
    const Eigen::Vector3d eye = Eigen::Vector3d(0, 0, eye_height) + aside * right;
    return Ray{eye, std::cos(elevation) * forward + std::sin(elevation) * Eigen::Vector3d::UnitZ(), pitch};
  };
}

RgbImage one_above_the_other(const RgbImage& above, const RgbImage& below) {
  RgbImage both(above.width, above.height + below.height);
  const auto end = std::copy(above.samples.begin(), above.samples.end(), both.samples.begin());
  std::copy(below.samples.begin(), below.samples.end(), end);
  return both;
}

}  // namespace

Surround take_surround(const Scene& scene, const SweepPath& path, const SurroundOptions& surround,
                       const PictureOptions& options, const Job& job) {
  const int width = surround.width;
  if (width < 4 || width % 2 != 0)
    throw std::logic_error("take_surround: width " + std::to_string(width) + ", expected an even one from 4");
  const auto take = [&](double aside) {
    return take_picture(scene, width, width / 2, rays_of(path.eye_height, surround, aside), options, job);
  };
  Picture middle = take(0);
  const RgbImage left = take(-surround.eyes / 2).colour, right = take(surround.eyes / 2).colour;
  return {std::move(middle.colour), one_above_the_other(left, right), std::move(middle.depth)};
}

}  // namespace ldp
