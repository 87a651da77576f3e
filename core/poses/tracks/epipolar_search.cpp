#include "core/poses/tracks/epipolar_search.h"

#include <algorithm>
#include <cmath>

#include "core/photos/halved.h"

namespace ldp {
namespace {

constexpr double kFarthest = 0.02, kClosest = 0.98;  // shares of what a frame sees between which distances are tried
constexpr double kCloser = 1.2;                      // and so much nearer than the nearest of these
constexpr double kStep_px = 1;                       // of half the picture, between places that are compared
constexpr int kLeastSteps = 3, kMostSteps = 200;
constexpr double kAlike = 0.7;       // correlation, the mean of both photos
constexpr double kClearly = 0.7;     // of the unlikeness of the next best distance
constexpr size_t kOnePeak = 2;       // steps within which two distances are one
constexpr double kNotCompared = -1;  // likeness where not both photos show it

// The likest, if others are clearly less alike.
std::optional<size_t> clear_peak(const std::vector<double>& likeness) {
  const size_t best = static_cast<size_t>(std::max_element(likeness.begin(), likeness.end()) - likeness.begin());
  if (likeness[best] < kAlike) return std::nullopt;
  double second = kNotCompared;
  for (size_t i = 0; i < likeness.size(); ++i) {
    if ((i > best ? i - best : best - i) <= kOnePeak) continue;
    const bool before = i == 0 || likeness[i] >= likeness[i - 1];
    const bool after = i + 1 == likeness.size() || likeness[i] >= likeness[i + 1];
    if (before && after) second = std::max(second, likeness[i]);
  }
  if (1 - likeness[best] > kClearly * (1 - second)) return std::nullopt;
  return best;
}

}  // namespace

AlongSight::AlongSight(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& bundle)
    : sweep_(sweep), bundle_(bundle), inverse_distances_(bundle.cameras.size()) {
  for (const GreyPhoto& picture : sweep.pictures) halves_.push_back(halved(picture.grey));
  for (size_t i = 0; i < tracks.size(); ++i) {
    for (const Observation& o : tracks[i]) {
      const size_t frame = static_cast<size_t>(o.frame);
      const double seen = bundle.points[i].seen_from(bundle.cameras[frame].centre).norm();
      inverse_distances_[frame].push_back(bundle.points[i].inverse_distance / seen);
    }
  }
  for (auto& of_frame : inverse_distances_) std::sort(of_frame.begin(), of_frame.end());
}

AlongSight::Found AlongSight::find(size_t frame, const Eigen::Vector2d& position_px) const {
  if (!knows(frame)) return {};
  const Sight sight = sight_through(frame, position_px);
  const Distances range = distances(frame);
  const std::optional<Others> others = beside(sight, range.usual);
  if (!others) return {};
  Patch<kPatch> here;
  const Eigen::Vector2d p = 0.5 * (sweep_.pictures[frame].scale.cwiseProduct(position_px) + middle(frame));
  if (!sample<kPatch>(halves_[frame], p, Eigen::Matrix2d::Identity(), here) || !normalise(here)) return {};
  const std::vector<double> alike = likeness(sight, here, *others, range);
  const std::optional<size_t> best = clear_peak(alike);
  if (!best) return {true, std::nullopt};
  const double share = static_cast<double>(*best) / static_cast<double>(alike.size() - 1);
  return {true, sight.at(range.least + (range.most - range.least) * share)};
}

Eigen::Vector2d AlongSight::from_picture(const Eigen::Vector2d& in_picture, size_t frame) const {
  return (in_picture - middle(frame)).cwiseQuotient(sweep_.pictures[frame].scale);
}

InversePoint AlongSight::Sight::at(double inverse_distance) const {
  const Eigen::Vector3d m = ray + inverse_distance * start;
  return {m.normalized(), inverse_distance / m.norm()};
}

AlongSight::Sight AlongSight::sight_through(size_t frame, const Eigen::Vector2d& position_px) const {
  const Pose& pose = bundle_.cameras[frame];
  const Eigen::Vector3d in_camera = ray_of(position_px, bundle_.lens).homogeneous().normalized();
  return {frame, position_px, pose.centre, pose.world_from_camera * in_camera};
}

AlongSight::Distances AlongSight::distances(size_t frame) const {
  const std::vector<double>& known = inverse_distances_[frame];
  const auto quantile = [&](double q) { return known[static_cast<size_t>(q * static_cast<double>(known.size() - 1))]; };
  return {std::min(0.0, quantile(kFarthest)), quantile(0.5), kCloser * quantile(kClosest)};
}

Eigen::Vector2d AlongSight::middle(size_t frame) const {
  const GreyImage& grey = sweep_.pictures[frame].grey;
  return 0.5 * Eigen::Vector2d(grey.width, grey.height);
}

// Where the frame shows a point, pixels of half the picture.
std::optional<Eigen::Vector2d> AlongSight::in_half(size_t frame, const InversePoint& point) const {
  const Projection there = project_point(bundle_.cameras[frame], bundle_.lens, point);
  if (!there.in_front) return std::nullopt;
  const Eigen::Vector2d p = sweep_.pictures[frame].scale.cwiseProduct(there.position_px) + middle(frame);
  const Eigen::Vector2d room = 2 * middle(frame) - p;
  if (std::min(p.minCoeff(), room.minCoeff()) < kSightMargin) return std::nullopt;
  return 0.5 * p;
}

// The two nearest of the frames that should show it.
std::optional<AlongSight::Others> AlongSight::beside(const Sight& sight, double inverse_distance) const {
  const InversePoint point = sight.at(inverse_distance);
  std::vector<std::pair<double, size_t>> near;
  for (size_t other = 0; other < bundle_.cameras.size(); ++other) {
    if (other == sight.frame || !knows(other) || !in_half(other, point)) continue;
    near.emplace_back((bundle_.cameras[other].centre - sight.start).norm(), other);
  }
  if (near.size() < 2) return std::nullopt;
  std::partial_sort(near.begin(), near.begin() + 2, near.end());
  return Others{near[0].second, near[1].second};
}

// Of offsets from the place to offsets in another frame, on a surface across the line of sight.
Eigen::Matrix2d AlongSight::warp(const Sight& sight, size_t frame, double inverse_distance) const {
  const auto there = [&](const Eigen::Vector2d& offset) {
    const Sight beside = sight_through(sight.frame, sight.position_px + offset);
    return project_point(bundle_.cameras[frame], bundle_.lens, beside.at(inverse_distance)).position_px;
  };
  const Eigen::Vector2d origin = there({0, 0});
  Eigen::Matrix2d linear;
  linear << there({1, 0}) - origin, there({0, 1}) - origin;
  return linear;
}

// So many that the farther of the places where others see it moves by no more than a step.
int AlongSight::steps(const Sight& sight, const Others& others, const Distances& range) const {
  double longest = 0;
  for (const size_t other : others) {
    const Projection far = project_point(bundle_.cameras[other], bundle_.lens, sight.at(range.least));
    const Projection near = project_point(bundle_.cameras[other], bundle_.lens, sight.at(range.most));
    const double moved = 0.5 * sweep_.pictures[sight.frame].scale.x() * (far.position_px - near.position_px).norm();
    longest = std::max(longest, far.in_front && near.in_front ? moved : kMostSteps * kStep_px);
  }
  const double wanted = longest / kStep_px + 1;
  return wanted < kMostSteps ? std::max(static_cast<int>(wanted), kLeastSteps) : kMostSteps;
}

// At equal steps of inverse distance, the mean correlation with what the two others show there.
std::vector<double> AlongSight::likeness(const Sight& sight, const Patch<kPatch>& here, const Others& others,
                                         const Distances& range) const {
  const std::array<Eigen::Matrix2d, 2> warps = {warp(sight, others[0], range.usual),
                                                warp(sight, others[1], range.usual)};
  const int count = steps(sight, others, range);
  std::vector<double> likeness(static_cast<size_t>(count) + 1, kNotCompared);
  for (size_t i = 0; i < likeness.size(); ++i) {
    const InversePoint point =
        sight.at(range.least + (range.most - range.least) * static_cast<double>(i) / static_cast<double>(count));
    double sum = 0;
    const auto compare = [&](size_t k) {
      const std::optional<Eigen::Vector2d> there = in_half(others[k], point);
      Patch<kPatch> patch;
      if (!there || !sample<kPatch>(halves_[others[k]], *there, warps[k], patch) || !normalise(patch)) return false;
      float product = 0;
      for (size_t j = 0; j < patch.size(); ++j) product += patch[j] * here[j];
      sum += static_cast<double>(product);
      return true;
    };
    if (compare(0) && compare(1)) likeness[i] = 0.5 * sum;
  }
  return likeness;
}

}  // namespace ldp
