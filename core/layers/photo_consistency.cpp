#include "core/layers/photo_consistency.h"

#include <algorithm>
#include <cstdlib>

#include "core/base/exact_math.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

using namespace tuning;

constexpr double kLeastForward = 0.1;  // as of the visibility maps

// By how much a value lies outside the range of 3x3 samples around (x, y).
int outside(int value, const GreyImage& image, int x, int y) {
  int low = 255, high = 0;
  for (int column = x - 1; column <= x + 1; ++column) {
    const uint8_t* samples = image.row(column) + y;
    for (int i = -1; i <= 1; ++i) {
      low = std::min<int>(low, samples[i]);
      high = std::max<int>(high, samples[i]);
    }
  }
  return std::max({0, value - high, low - value});
}

struct Place {
  int x, y;
};

bool has_neighbours(const UprightFrame& frame, Place at) {
  if (at.x < 1 || at.x + 1 >= frame.camera.width) return false;
  const auto column = static_cast<size_t>(at.x);
  return at.y >= frame.valid_begin[column] + 1 && at.y + 1 < frame.valid_end[column];
}

int apart(const GreyImage& a, Place in_a, const GreyImage& b, Place in_b) {
  return std::max(outside(a.row(in_a.x)[in_a.y], b, in_b.x, in_b.y), outside(b.row(in_b.x)[in_b.y], a, in_a.x, in_a.y));
}

// Half a pixel around or not.
int farthest_apart(const UprightFrame& a, Place in_a, const UprightFrame& b, Place in_b) {
  return std::abs(a.columns.row(in_a.x)[in_a.y] - b.columns.row(in_b.x)[in_b.y]) +
         std::abs(a.tint.row(in_a.x)[in_a.y] - b.tint.row(in_b.x)[in_b.y]);
}

}  // namespace

PhotoConsistency::Witness::Witness(size_t other, const UprightCamera& from, const UprightCamera& to,
                                   const Eigen::Vector3d& down)
    : frame(other),
      right_of_right(exact_dot(to.right, from.right)),
      right_of_forward(exact_dot(to.right, from.forward)),
      forward_of_right(exact_dot(to.forward, from.right)),
      forward_of_forward(exact_dot(to.forward, from.forward)),
      step_right(exact_dot(to.right, from.centre - to.centre)),
      step_down(exact_dot(down, from.centre - to.centre)),
      step_forward(exact_dot(to.forward, from.centre - to.centre)) {}

PhotoConsistency::PhotoConsistency(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames)
    : frames_(frames) {
  const Eigen::Vector3d down = -grid.arc.axis();
  for (size_t k = 0; k < frames.size(); ++k) {
    const UprightCamera& own = frames[k].camera;
    std::vector<std::pair<double, size_t>> beside;
    for (size_t j = 0; j < frames.size(); ++j) {
      const UprightCamera& other = frames[j].camera;
      if (j == k || exact_dot(other.forward, own.forward) < kWitnessCosine) continue;
      const Eigen::Vector3d step = other.centre - own.centre;
      beside.emplace_back(exact_dot(step, step), j);
    }
    std::sort(beside.begin(), beside.end());
    std::vector<Witness>& witnesses = witnesses_.emplace_back();
    for (size_t i = 0; i < std::min(beside.size(), kWitnesses); ++i)
      witnesses.emplace_back(beside[i].second, own, frames[beside[i].second].camera, down);
  }
}

std::vector<size_t> PhotoConsistency::witnesses(size_t k) const {
  std::vector<size_t> cameras;
  for (const Witness& witness : witnesses_[k]) cameras.push_back(witness.frame);
  return cameras;
}

int PhotoConsistency::difference(size_t k, int x, int y, const std::vector<const VisibilityMap*>& maps) const {
  const UprightFrame& own = frames_[k];
  const uint16_t steps = maps[k]->inverse_z.row(x)[y];
  if (steps == kUncovered || !has_neighbours(own, {x, y})) return kUnknownDifference;
  const double inverse_z = steps * maps[k]->scale;
  const double to_right = (x + 0.5 - own.camera.cx) / own.camera.focal,
               to_down = (y + 0.5 - own.camera.cy) / own.camera.focal;
  int sum = 0, views = 0;
  for (const Witness& to : witnesses_[k]) {
    const UprightFrame& other = frames_[to.frame];
    const VisibilityMap& map = *maps[to.frame];
    const double forward = to.forward_of_forward + to_right * to.forward_of_right + inverse_z * to.step_forward;
    if (forward < kLeastForward) continue;
    const double right = to.right_of_forward + to_right * to.right_of_right + inverse_z * to.step_right,
                 down = to_down + inverse_z * to.step_down;
    const double x_px = other.camera.focal * right / forward + other.camera.cx,
                 y_px = other.camera.focal * down / forward + other.camera.cy;
    if (!(x_px >= 0 && x_px < other.camera.width && y_px >= 0 && y_px < other.camera.height)) continue;
    const Place there{static_cast<int>(x_px), static_cast<int>(y_px)};
    if (!has_neighbours(other, there)) continue;
    if (map.inverse_z.row(there.x)[there.y] > std::min(inverse_z / forward / map.scale, 65535.0) + map.tolerance)
      continue;
    ++views;
    if (farthest_apart(own, {x, y}, other, there) <= kWitnessNoise) continue;
    const int differ =
        apart(own.columns, {x, y}, other.columns, there) + apart(own.tint, {x, y}, other.tint, there) - kWitnessNoise;
    sum += std::clamp(differ, 0, kWitnessMostDiffer) * kDifferenceSteps;
  }
  return views == 0 ? kUnknownDifference : sum / views;
}

}  // namespace ldp::layers
