#include "core/rectify/resample.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/base/exact_math.h"
#include "core/photos/catmull_rom.h"
#include "core/rectify/rectify_tuning.h"

namespace ldp::rectification {
namespace {

// The line of sight less its part along the axis.
Eigen::Vector3d level_forward(const Camera& camera, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d forward = camera.pose.world_from_camera.col(2);
  return forward - exact_dot(forward, axis) * axis;
}

double length(const Eigen::Vector3d& v) { return std::sqrt(exact_dot(v, v)); }

Eigen::Vector3d horizontal_forward(const Camera& camera, const Eigen::Vector3d& axis) {
  if (is_along(camera, axis)) {
    throw std::runtime_error(
        "photo '" + camera.name +
        "' looks straight up or down: leave it out of the capture, or, where the camera lay on its "
        "side, add a turn by 90 or by 270 degrees (where it stood upright, leave the turn out)");
  }
  const Eigen::Vector3d level = level_forward(camera, axis);
  return level / length(level);
}

struct Bounds {
  double low = 0, high = 0;
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

// Tangents (right and down) spanned by the photo's outline; each within kMaxUprightTangent.
std::array<Bounds, 2> outline(const Camera& camera, const UprightCamera& upright, const Eigen::Vector3d& axis) {
  std::array<Bounds, 2> bounds;
  const Intrinsics& k = camera.intrinsics;
  const auto include = [&](double x_px, double y_px) {
    const Eigen::Vector3d d = exact_product(camera.pose.world_from_camera, unproject(k, {x_px, y_px}));
    const double z = std::max(exact_dot(d, upright.forward), 1e-6);
    bounds[0].include(std::clamp(exact_dot(d, upright.right) / z, -kMaxUprightTangent, kMaxUprightTangent));
    bounds[1].include(std::clamp(-exact_dot(d, axis) / z, -kMaxUprightTangent, kMaxUprightTangent));
  };
  for (int i = 0; i <= kOutlineSteps; ++i) {
    const double x = k.width * static_cast<double>(i) / kOutlineSteps,
                 y = k.height * static_cast<double>(i) / kOutlineSteps;
    include(x, 0);
    include(x, k.height);
    include(0, y);
    include(k.width, y);
  }
  return bounds;
}

// Catmull-Rom weights in 1/128 for each 1/256 of a pixel; they sum to 128.
std::array<std::array<int16_t, 4>, 256> rounded_weights() {
  constexpr int kWholeBits = 26;  // of twice the denominator
  constexpr int64_t kWhole = catmull_rom_whole(256);
  static_assert(2 * kWhole == int64_t{1} << kWholeBits);
  std::array<std::array<int16_t, 4>, 256> table{};
  for (size_t i = 0; i < 256; ++i) {
    const std::array<int64_t, 4> exact = catmull_rom(static_cast<int64_t>(i), 256);
    int sum = 0;
    for (size_t k = 0; k < 4; ++k)
      sum += table[i][k] = static_cast<int16_t>((256 * exact[k] + kWhole) >> kWholeBits);  // to the nearest
    int16_t& largest = table[i][i < 128 ? 1 : 2];
    largest = static_cast<int16_t>(largest + 128 - sum);
  }
  return table;
}

}  // namespace

bool is_along(const Camera& camera, const Eigen::Vector3d& axis) {
  return length(level_forward(camera, axis)) < kMinLevelForward;
}

UprightCamera upright_camera(const Camera& camera, const Eigen::Vector3d& axis, int source, double pitch_px) {
  UprightCamera upright;
  upright.centre = camera.pose.centre;
  upright.forward = horizontal_forward(camera, axis);
  upright.right = upright.forward.cross(axis);
  upright.focal = (camera.intrinsics.fx + camera.intrinsics.fy) / 2 / pitch_px;
  upright.source = source;
  const auto [across, down] = outline(camera, upright, axis);
  upright.cx = std::ceil(-across.low * upright.focal);
  upright.cy = std::ceil(-down.low * upright.focal);
  upright.width = static_cast<int>(upright.cx + std::ceil(across.high * upright.focal));
  upright.height = static_cast<int>(upright.cy + std::ceil(down.high * upright.focal));
  return upright;
}

ColumnMap::ColumnMap(const Camera& camera, const UprightCamera& upright, double column)
    : intrinsics_(camera.intrinsics) {
  const Eigen::Vector3d down = upright.forward.cross(upright.right);
  const Eigen::Matrix3d& world_from_camera = camera.pose.world_from_camera;
  const double across = (column + 0.5 - upright.cx) / upright.focal, first_row = (0.5 - upright.cy) / upright.focal;
  first_ = exact_transposed_product(world_from_camera, upright.forward + across * upright.right + first_row * down);
  step_ = exact_transposed_product(world_from_camera, down / upright.focal);
}

SourcePosition ColumnMap::at(double row) const {
  const Eigen::Vector3d d = first_ + row * step_;
  if (d.z() <= 1e-3) return {};
  const Eigen::Vector2d position = project(intrinsics_, d);
  const double right_q8 = (intrinsics_.width - 1) * 256.0, bottom_q8 = (intrinsics_.height - 1) * 256.0;
  const double x = (position.x() - 0.5) * 256 + 0.5, y = (position.y() - 0.5) * 256 + 0.5;  // to be cut to whole ones
  const bool inside = x >= 0 && y >= 0 && x < right_q8 + 1 && y < bottom_q8 + 1;
  return {static_cast<int>(std::clamp(x, 0.0, right_q8)), static_cast<int>(std::clamp(y, 0.0, bottom_q8)), inside};
}

Interpolation::Interpolation(const SourcePosition& position)
    : x0_((position.x_q8 >> 8) - 1), y0_((position.y_q8 >> 8) - 1) {
  static const auto kWeights = rounded_weights();
  const auto& across = kWeights[static_cast<size_t>(position.x_q8 & 255)];
  const auto& down = kWeights[static_cast<size_t>(position.y_q8 & 255)];
  for (size_t i = 0; i < kTaps; ++i) weights_[i] = static_cast<int16_t>(across[i % 4] * down[i / 4]);
}

uint8_t Interpolation::operator()(const Plane<uint16_t>& plane) const {
  uint16_t samples[kTaps];
  if (x0_ >= 0 && y0_ >= 0 && x0_ + 3 < plane.width && y0_ + 3 < plane.height) {
    const uint16_t* row = plane.row(y0_) + x0_;
    for (size_t j = 0; j < 4; ++j, row += plane.width) std::copy_n(row, 4, samples + 4 * j);
  } else {
    for (int i = 0; i < kTaps; ++i)
      samples[i] = plane.at(std::clamp(x0_ + i % 4, 0, plane.width - 1), std::clamp(y0_ + i / 4, 0, plane.height - 1));
  }
  int sum = 0;  // at most 255 * kSampleScale * 160 * 160 < 2^31
  for (size_t i = 0; i < kTaps; ++i) sum += weights_[i] * static_cast<int16_t>(samples[i]);
  constexpr int kShift = 7 + 7 + 6;
  return static_cast<uint8_t>(std::clamp((sum + (1 << (kShift - 1))) >> kShift, 0, 255));
}

}  // namespace ldp::rectification
