#include "core/photos/exposure/local_exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/exact_math.h"
#include "core/photos/exposure_tuning.h"

namespace ldp {

using namespace exposure;

namespace {

Eigen::Vector3d normalised(const Eigen::Vector3d& v) { return v / std::sqrt(exact_dot(v, v)); }

std::array<uint16_t, 3> node_of(const std::array<double, 3>& log_gain) {
  std::array<uint16_t, 3> node{};
  for (size_t c = 0; c < 3; ++c)
    node[c] = static_cast<uint16_t>(
        std::clamp(std::floor(exact_exp(log_gain[c]) * GainField::kOne + 0.5), 1.0, double{UINT16_MAX}));
  return node;
}

std::array<double, 3> log_of(const Gain& gain) {
  std::array<double, 3> log_gain{};
  for (size_t c = 0; c < 3; ++c) log_gain[c] = exact_log(static_cast<double>(gain[c]));
  return log_gain;
}

int nodes_along(double pixels, double pixels_per_node) {
  return std::clamp(static_cast<int>(std::lround(pixels / pixels_per_node)), 1, kMostNodes);
}

}  // namespace

LocalExposure::LocalExposure(const std::vector<Camera>& cameras, const std::vector<Gain>& gains) : cameras_(cameras) {
  for (const Gain& gain : gains) log_gains_.push_back(log_of(gain));
}

bool LocalExposure::is_wanted() const {
  const double least = exact_log(kLeastLocalFactor);
  return std::any_of(cameras_.begin(), cameras_.end(), [&](const Camera& camera) {
    const LogGain factor = log_factor(camera.pose.world_from_camera.col(2));
    return std::any_of(factor.begin(), factor.end(), [&](double f) { return std::abs(f) > least; });
  });
}

// Squared chords stand for squared angles: between the axes of photographs that matter they are much the same.
LocalExposure::LogGain LocalExposure::log_factor(const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d ray = normalised(direction);
  std::vector<double> chords;
  for (const Camera& camera : cameras_) chords.push_back(2 - 2 * exact_dot(ray, camera.pose.world_from_camera.col(2)));
  const double nearest = *std::min_element(chords.begin(), chords.end());
  LogGain sum{};
  double weights = 0;
  for (size_t k = 0; k < chords.size(); ++k) {
    const double weight = exact_exp(-(chords[k] - nearest) / (2 * kLocalSigma_rad * kLocalSigma_rad));
    weights += weight;
    for (size_t c = 0; c < 3; ++c) sum[c] -= weight * log_gains_[k][c];
  }
  for (double& s : sum) s /= weights;
  return sum;
}

GainField LocalExposure::over(const PanoramaGrid& grid) const {
  GainField field;
  field.wraps = grid.wraps;
  const int columns = nodes_along(grid.width, kNode_rad / grid.theta_pitch);
  const int rows = nodes_along(grid.height, kNode_rad / grid.v_pitch);
  field.nodes = {columns, rows};
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double theta = grid.theta((i + 0.5) * grid.width / columns), v = grid.v((j + 0.5) * grid.height / rows);
      const auto [sine, cosine] = exact_sine_cosine(theta);
      field.nodes.at(i, j) = node_of(log_factor(exact_product(grid.arc.world_from_arc, {cosine, sine, v})));
    }
  return field;
}

GainField LocalExposure::over_photo(size_t camera) const {
  return over_picture(cameras_[camera], log_gains_[camera], 1);
}

GainField LocalExposure::back_to_photo(const Camera& view, const Gain& gain) const {
  return over_picture(view, log_of(gain), -1);
}

// The gain and the factors of where a picture's pixels look, to the power of `sign`.
GainField LocalExposure::over_picture(const Camera& from, const LogGain& log_gain, double sign) const {
  const Intrinsics& lens = from.intrinsics;
  GainField field;
  field.nodes = {nodes_along(lens.width, kNode_rad * lens.fx), nodes_along(lens.height, kNode_rad * lens.fy)};
  for (int j = 0; j < field.nodes.height; ++j)
    for (int i = 0; i < field.nodes.width; ++i) {
      const Eigen::Vector2d at((i + 0.5) * lens.width / field.nodes.width,
                               (j + 0.5) * lens.height / field.nodes.height);
      LogGain factor = log_factor(exact_product(from.pose.world_from_camera, unproject(lens, at)));
      for (size_t c = 0; c < 3; ++c) factor[c] = sign * (factor[c] + log_gain[c]);
      field.nodes.at(i, j) = node_of(factor);
    }
  return field;
}

}  // namespace ldp
