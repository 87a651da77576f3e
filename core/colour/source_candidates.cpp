#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/colour/blending.h"
#include "core/colour/colour.h"
#include "core/colour/colour_tuning.h"

namespace ldp::colour {
namespace {

using namespace tuning;

constexpr double kCostPerDegree = 64;
constexpr double kCostPerRadian = kCostPerDegree * 180 / std::numbers::pi;
constexpr int kColumnsAtOnce = 64;

// The values in the middle when sorted: of an odd number the median twice.
struct Middle {
  int low = 0, high = 0;

  template <typename Value>
  Middle(int count, const Value& value) {
    std::array<int, kMaxCandidates> sorted;
    for (int i = 0; i < count; ++i) {
      const int next = value(i);
      auto place = static_cast<size_t>(i);
      for (; place > 0 && sorted[place - 1] > next; --place) sorted[place] = sorted[place - 1];
      sorted[place] = next;
    }
    low = sorted[static_cast<size_t>((count - 1) / 2)], high = sorted[static_cast<size_t>(count / 2)];
  }
  int beyond(int noise, int value) const { return std::max({0, low - value - noise, value - high - noise}); }
};

}  // namespace
}  // namespace ldp::colour

namespace ldp {

using namespace colour;

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
  std::vector<std::pair<double, uint16_t>> frames;
  for (size_t i = 0; i < projections_.size(); ++i) {
    const auto u = projections_[i].column(h);
    const bool far = u.forward > kLeastForward, near = projections_[i].forward(u, grid_.w_near) > kLeastForward;
    if (far || near) frames.emplace_back(std::abs(projections_[i].aside(h)), static_cast<uint16_t>(i));
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
  const auto in_map = [](double position_px, int size) {
    return std::clamp(static_cast<int>(position_px), 0, size - 1);
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

SourceCandidates::Candidate SourceCandidates::candidate(uint16_t frame, int x, int y, double w, bool through) const {
  const VoxelProjection& projection = projections_[frame];
  const auto u = projection.column(headings_[static_cast<size_t>(x)]);
  const double forward = projection.forward(u, w);
  if (forward < kLeastForward) return {};
  const UprightCamera& camera = frames_[frame].camera;
  const double right = projection.right(u, w), x_px = camera.focal * right / forward + camera.cx;
  if (!(x_px >= 0.5 && x_px < camera.width - 0.5)) return {};
  const double v = grid_.v(y + 0.5), up = projection.up(v, w), y_px = camera.cy - camera.focal * up / forward;
  const Seen seen = look(frame, x_px, y_px, w / forward, through);
  if (!seen.visible) return {};
  // Chord between the unit vectors of both rays: the angle, to 2 % up to 40 degrees.
  const double length2 = (right * right + forward * forward + up * up) * (1 + v * v);
  const double cosine = (right * u.right + forward * u.forward + up * v) / std::sqrt(length2);
  const double chord = std::sqrt(std::max(0.0, 2 - 2 * cosine));
  const double off_x = (x_px - camera.cx) / camera.width, off_y = (y_px - camera.cy) / camera.height;
  const double off_axis = options_.off_axis_deg * 2 * (off_x * off_x + off_y * off_y);
  const double cost = chord * kCostPerRadian + kCostPerDegree * (off_axis + (seen.mixed ? options_.mixed_deg : 0));
  const int x16 = static_cast<int>((x_px - 0.5) * 16), y16 = static_cast<int>((y_px - 0.5) * 16);
  return {frame, static_cast<int>(cost), interpolated(frames_[frame].columns, x16, y16),
          interpolated(frames_[frame].tint, x16, y16)};
}

int SourceCandidates::candidates(int x, int y, uint16_t frame[16], uint16_t cost[16]) const {
  const int count = collect(x, y, false, frame, cost);
  return count == 0 && options_.guess_hidden ? collect(x, y, true, frame, cost) : count;
}

int SourceCandidates::collect(int x, int y, bool through, uint16_t frame[16], uint16_t cost[16]) const {
  const double w = grid_.inverse_depth(layer_.at(x, y));
  std::array<Candidate, kMaxCandidates> found;
  int count = 0;
  for (const uint16_t i : facing_[static_cast<size_t>(x)]) {
    if (count == kMaxCandidates) break;
    const Candidate c = candidate(i, x, y, w, through);
    if (c.cost < 0) continue;
    int at = count++;  // frames stay in rising order
    for (; at > 0 && found[static_cast<size_t>(at) - 1].frame > i; --at)
      found[static_cast<size_t>(at)] = found[static_cast<size_t>(at) - 1];
    found[static_cast<size_t>(at)] = c;
  }
  doubt_odd_ones(options_.disagree_deg * kCostPerDegree, found.data(), found.data() + count);
  for (int k = 0; k < count; ++k) {
    frame[k] = found[static_cast<size_t>(k)].frame;
    cost[k] = static_cast<uint16_t>(std::min(found[static_cast<size_t>(k)].cost, 65534));
  }
  return count;
}

bool SourceCandidates::sees(int frame, int x, int y) const {
  return candidate(static_cast<uint16_t>(frame), x, y, grid_.inverse_depth(layer_.at(x, y)), false).cost >= 0;
}

int SourceCandidates::cheapest(int x, int y) const {
  uint16_t frame[kMaxCandidates], cost[kMaxCandidates];
  const int count = candidates(x, y, frame, cost);
  return count > 0 ? frame[std::min_element(cost, cost + count) - cost] : kNoSource;
}

uint8_t SourceCandidates::neighbours_of(int x, int y, int own) const {
  int bits = 0;
  for (int other = std::max(0, own - kViewsAside); other <= std::min(frames() - 1, own + kViewsAside); ++other)
    if (other != own && sees(other, x, y)) bits |= 1 << neighbour_bit(other - own);
  return static_cast<uint8_t>(bits);
}

// A few columns at a time: they are few columns of the frames, too.
Plane<uint8_t> SourceCandidates::neighbours(const SourceMap& source, const Job& job) const {
  Plane<uint8_t> seen_by(source.width(), source.height(), 0);
  parallel_for(job, (source.width() + kColumnsAtOnce - 1) / kColumnsAtOnce, [&](int strip) {
    const int begin = strip * kColumnsAtOnce, end = std::min(source.width(), begin + kColumnsAtOnce);
    for (int y = 0; y < source.height(); ++y)
      for (int x = begin; x < end; ++x)
        if (source.at(x, y) != kNoSource) seen_by.at(x, y) = neighbours_of(x, y, source.at(x, y));
  });
  return seen_by;
}

// Most cameras see the voxel's own surface: one that sees another, or a mixture of two, stands out. Of two cameras
// neither does.
void SourceCandidates::doubt_odd_ones(double cost_per_level, Candidate* begin, Candidate* end) {
  const int count = static_cast<int>(end - begin);
  if (count < 3) return;
  const Middle grey(count, [&](int i) { return begin[i].grey; }), tint(count, [&](int i) { return begin[i].tint; });
  for (Candidate* c = begin; c != end; ++c) {
    const int levels = grey.beyond(kNoise, c->grey) + tint.beyond(kNoise, c->tint);
    c->cost += static_cast<int>(cost_per_level * std::min(kMostDiffer, levels));
  }
}

uint8_t SourceCandidates::depth_label(int x, int y) const {
  const int d = layer_.at(x, y);
  if (d == kNoDisparity) return 0;
  return static_cast<uint8_t>((d * (kLabels - 1) + kDisparitySteps / 2) / kDisparitySteps);
}

}  // namespace ldp
