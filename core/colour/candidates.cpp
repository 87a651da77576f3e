#include <algorithm>
#include <cmath>
#include <numbers>

#include "colour.h"

namespace ldp {
namespace {

constexpr double kCostPerDegree = 64;
constexpr double kCostPerRadian = kCostPerDegree * 180 / std::numbers::pi;
constexpr int kMaxCandidates = 8;      // the cameras nearest to the ray among those that see the voxel
constexpr double kBehindCamera = 0.1;  // least forward * w of a voxel worth projecting

}  // namespace

SourceCandidates::SourceCandidates(const PanoramaGrid& grid, const DisparityMap& layer,
                                   const std::vector<UprightFrame>& frames,
                                   const std::vector<VisibilityMap>& visibility, const ColourOptions& options)
    : grid_(grid),
      layer_(layer),
      frames_(frames),
      visibility_(visibility.empty() ? nullptr : &visibility),
      options_(options) {
  for (const UprightFrame& frame : frames) projections_.emplace_back(grid, frame.camera);
  facing_.resize(static_cast<size_t>(grid.width));
  for (int x = 0; x < grid.width; ++x) {
    headings_.push_back(heading(grid.theta(x + 0.5)));
    find_facing(x);
  }
}

void SourceCandidates::find_facing(int x) {
  const Heading h = headings_[static_cast<size_t>(x)];
  std::vector<std::pair<double, uint8_t>> frames;
  for (size_t i = 0; i < projections_.size(); ++i) {
    const auto u = projections_[i].column(h);
    const bool far = u.forward > kBehindCamera, near = projections_[i].forward(u, grid_.w_near) > kBehindCamera;
    if (far || near) frames.emplace_back(std::abs(projections_[i].aside(h)), static_cast<uint8_t>(i));
  }
  std::sort(frames.begin(), frames.end());
  auto& facing = facing_[static_cast<size_t>(x)];
  for (const auto& [aside, frame] : frames) facing.push_back(frame);
}

SourceCandidates::Seen SourceCandidates::look(size_t frame, double x_px, double y_px, double inverse_z,
                                              bool through) const {
  const UprightFrame& upright = frames_[frame];
  const auto column = static_cast<size_t>(x_px);
  if (y_px < upright.valid_begin[column] + 0.5 || y_px >= upright.valid_end[column] - 0.5) return {};
  if (!visibility_ || through) return {true, false};
  const VisibilityMap& map = (*visibility_)[frame];
  const int limit = static_cast<int>(inverse_z / map.scale) + map.tolerance;
  const auto in_map = [&](double position_px, int size) {
    const double place = map.shrink == 1 ? position_px : position_px / map.shrink;
    return std::clamp(static_cast<int>(place), 0, size - 1);
  };
  const auto nearest = [&](double x, double y) {
    return static_cast<int>(map.inverse_z.at(in_map(y, map.inverse_z.width), in_map(x, map.inverse_z.height)));
  };
  if (nearest(x_px, y_px) > limit) return {};
  const double reach = options_.mixed_px;
  const bool mixed = nearest(x_px - reach, y_px) > limit || nearest(x_px + reach, y_px) > limit ||
                     nearest(x_px, y_px - reach) > limit || nearest(x_px, y_px + reach) > limit;
  return {true, mixed};
}

int SourceCandidates::cost_from(size_t frame, int x, int y, double w, bool through) const {
  const VoxelProjection& projection = projections_[frame];
  const auto u = projection.column(headings_[static_cast<size_t>(x)]);
  const double forward = projection.forward(u, w);
  if (forward < kBehindCamera) return -1;
  const UprightCamera& camera = frames_[frame].camera;
  const double right = projection.right(u, w), x_px = camera.focal * right / forward + camera.cx;
  if (!(x_px >= 0.5 && x_px < camera.width - 0.5)) return -1;
  const double v = grid_.v(y + 0.5), up = projection.up(v, w), y_px = camera.cy - camera.focal * up / forward;
  const Seen seen = look(frame, x_px, y_px, w / forward, through);
  if (!seen.visible) return -1;
  // Chord between the unit vectors of both rays: the angle, to 2 % up to 40 degrees.
  const double length2 = (right * right + forward * forward + up * up) * (1 + v * v);
  const double cosine = (right * u.right + forward * u.forward + up * v) / std::sqrt(length2);
  const double chord = std::sqrt(std::max(0.0, 2 - 2 * cosine));
  const double off_x = (x_px - camera.cx) / camera.width, off_y = (y_px - camera.cy) / camera.height;
  const double off_axis = options_.off_axis_deg * 2 * (off_x * off_x + off_y * off_y);
  const double cost = chord * kCostPerRadian + kCostPerDegree * (off_axis + (seen.mixed ? options_.mixed_deg : 0));
  return static_cast<int>(std::min(cost, 65534.0));
}

int SourceCandidates::candidates(int x, int y, uint8_t frame[16], uint16_t cost[16]) const {
  const int count = collect(x, y, false, frame, cost);
  return count == 0 && options_.guess_hidden ? collect(x, y, true, frame, cost) : count;
}

int SourceCandidates::collect(int x, int y, bool through, uint8_t frame[16], uint16_t cost[16]) const {
  const double w = grid_.inverse_depth(layer_.at(x, y));
  int count = 0;
  for (const uint8_t i : facing_[static_cast<size_t>(x)]) {
    if (count == kMaxCandidates) break;
    const int c = cost_from(i, x, y, w, through);
    if (c < 0) continue;
    int at = count++;  // frames stay in rising order
    for (; at > 0 && frame[at - 1] > i; --at) {
      frame[at] = frame[at - 1];
      cost[at] = cost[at - 1];
    }
    frame[at] = i;
    cost[at] = static_cast<uint16_t>(c);
  }
  return count;
}

uint8_t SourceCandidates::depth_label(int x, int y) const {
  const int d = layer_.at(x, y);
  if (d == kNoDisparity) return 0;
  return static_cast<uint8_t>((d * (kLabels - 1) + kDisparitySteps / 2) / kDisparitySteps);
}

}  // namespace ldp
