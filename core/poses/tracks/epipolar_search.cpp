#include "core/poses/tracks/epipolar_search.h"

#include <algorithm>
#include <cmath>

#include "core/photos/halved.h"
#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

constexpr double kNotCompared = -1;  // correlation where not both photos show it

// The likest, if others are clearly less alike.
std::optional<size_t> distinct_peak(const std::vector<double>& correlation) {
  const size_t best =
      static_cast<size_t>(std::max_element(correlation.begin(), correlation.end()) - correlation.begin());
  if (correlation[best] < kMinSearchCorrelation) return std::nullopt;
  double second = kNotCompared;
  for (size_t i = 0; i < correlation.size(); ++i) {
    if ((i > best ? i - best : best - i) <= kPeakWidth_steps) continue;
    const bool before = i == 0 || correlation[i] >= correlation[i - 1];
    const bool after = i + 1 == correlation.size() || correlation[i] >= correlation[i + 1];
    if (before && after) second = std::max(second, correlation[i]);
  }
  if (1 - correlation[best] > kMaxSearchRatio * (1 - second)) return std::nullopt;
  return best;
}

}  // namespace

EpipolarSearch::EpipolarSearch(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& bundle)
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

EpipolarSearch::Found EpipolarSearch::search(size_t frame, const Eigen::Vector2d& position_px) const {
  if (!sees_known_points(frame)) return {};
  const ViewingRay ray = viewing_ray(frame, position_px);
  const InverseDistanceRange range = inverse_distance_range(frame);
  const std::optional<ViewPair> others = nearest_views(ray, range.median);
  if (!others) return {};
  Patch<kSearchPatchRadius_px> here;
  const Eigen::Vector2d p = 0.5 * (sweep_.pictures[frame].scale.cwiseProduct(position_px) + middle(frame));
  if (!sample<kSearchPatchRadius_px>(halves_[frame], p, Eigen::Matrix2d::Identity(), here) || !normalise(here))
    return {};
  const std::vector<double> alike = correlations(ray, here, *others, range);
  const std::optional<size_t> best = distinct_peak(alike);
  if (!best) return {true, std::nullopt};
  const double share = static_cast<double>(*best) / static_cast<double>(alike.size() - 1);
  return {true, ray.at(range.min + (range.max - range.min) * share)};
}

Eigen::Vector2d EpipolarSearch::from_picture(const Eigen::Vector2d& in_picture, size_t frame) const {
  return (in_picture - middle(frame)).cwiseQuotient(sweep_.pictures[frame].scale);
}

InversePoint EpipolarSearch::ViewingRay::at(double inverse_distance) const {
  const Eigen::Vector3d m = direction + inverse_distance * origin;
  return {m.normalized(), inverse_distance / m.norm()};
}

EpipolarSearch::ViewingRay EpipolarSearch::viewing_ray(size_t frame, const Eigen::Vector2d& position_px) const {
  const Pose& pose = bundle_.cameras[frame];
  const Eigen::Vector3d in_camera = undistorted_ray(position_px, bundle_.lens).homogeneous().normalized();
  return {frame, position_px, pose.centre, pose.world_from_camera * in_camera};
}

EpipolarSearch::InverseDistanceRange EpipolarSearch::inverse_distance_range(size_t frame) const {
  const std::vector<double>& known = inverse_distances_[frame];
  const auto quantile = [&](double q) { return known[static_cast<size_t>(q * static_cast<double>(known.size() - 1))]; };
  return {std::min(0.0, quantile(kFarQuantile)), quantile(0.5), kNearMargin * quantile(kNearQuantile)};
}

Eigen::Vector2d EpipolarSearch::middle(size_t frame) const {
  const GreyImage& grey = sweep_.pictures[frame].grey;
  return 0.5 * Eigen::Vector2d(grey.width, grey.height);
}

// Where the frame shows a point, pixels of half the picture.
std::optional<Eigen::Vector2d> EpipolarSearch::project_to_half(size_t frame, const InversePoint& point) const {
  const Projection there = project_point(bundle_.cameras[frame], bundle_.lens, point);
  if (!there.in_front) return std::nullopt;
  const Eigen::Vector2d p = sweep_.pictures[frame].scale.cwiseProduct(there.position_px) + middle(frame);
  const Eigen::Vector2d room = 2 * middle(frame) - p;
  if (std::min(p.minCoeff(), room.minCoeff()) < kSearchMargin_px) return std::nullopt;
  return 0.5 * p;
}

// The two nearest of the frames that should show it.
std::optional<EpipolarSearch::ViewPair> EpipolarSearch::nearest_views(const ViewingRay& ray,
                                                                      double inverse_distance) const {
  const InversePoint point = ray.at(inverse_distance);
  std::vector<std::pair<double, size_t>> near;
  for (size_t other = 0; other < bundle_.cameras.size(); ++other) {
    if (other == ray.frame || !sees_known_points(other) || !project_to_half(other, point)) continue;
    near.emplace_back((bundle_.cameras[other].centre - ray.origin).norm(), other);
  }
  if (near.size() < 2) return std::nullopt;
  std::partial_sort(near.begin(), near.begin() + 2, near.end());
  return ViewPair{near[0].second, near[1].second};
}

// Of offsets from the place to offsets in another frame, on a surface across the line of sight.
Eigen::Matrix2d EpipolarSearch::warp(const ViewingRay& ray, size_t frame, double inverse_distance) const {
  const auto there = [&](const Eigen::Vector2d& offset) {
    const ViewingRay beside = viewing_ray(ray.frame, ray.position_px + offset);
    return project_point(bundle_.cameras[frame], bundle_.lens, beside.at(inverse_distance)).position_px;
  };
  const Eigen::Vector2d origin = there({0, 0});
  Eigen::Matrix2d linear;
  linear << there({1, 0}) - origin, there({0, 1}) - origin;
  return linear;
}

// So many that the farther of the places where others see it moves by no more than a step.
int EpipolarSearch::step_count(const ViewingRay& ray, const ViewPair& others, const InverseDistanceRange& range) const {
  double longest = 0;
  for (const size_t other : others) {
    const Projection far = project_point(bundle_.cameras[other], bundle_.lens, ray.at(range.min));
    const Projection near = project_point(bundle_.cameras[other], bundle_.lens, ray.at(range.max));
    const double moved = 0.5 * sweep_.pictures[ray.frame].scale.x() * (far.position_px - near.position_px).norm();
    longest = std::max(longest, far.in_front && near.in_front ? moved : kMaxSearchSteps * kSearchStep_px);
  }
  const double wanted = longest / kSearchStep_px + 1;
  return wanted < kMaxSearchSteps ? std::max(static_cast<int>(wanted), kMinSearchSteps) : kMaxSearchSteps;
}

// At equal steps of inverse distance, the mean correlation with what the two others show there.
std::vector<double> EpipolarSearch::correlations(const ViewingRay& ray, const Patch<kSearchPatchRadius_px>& here,
                                                 const ViewPair& others, const InverseDistanceRange& range) const {
  const std::array<Eigen::Matrix2d, 2> warps = {warp(ray, others[0], range.median), warp(ray, others[1], range.median)};
  const int count = step_count(ray, others, range);
  std::vector<double> correlation(static_cast<size_t>(count) + 1, kNotCompared);
  for (size_t i = 0; i < correlation.size(); ++i) {
    const InversePoint point =
        ray.at(range.min + (range.max - range.min) * static_cast<double>(i) / static_cast<double>(count));
    double sum = 0;
    const auto compare = [&](size_t k) {
      const std::optional<Eigen::Vector2d> there = project_to_half(others[k], point);
      Patch<kSearchPatchRadius_px> patch;
      if (!there || !sample<kSearchPatchRadius_px>(halves_[others[k]], *there, warps[k], patch) || !normalise(patch))
        return false;
      float product = 0;
      for (size_t j = 0; j < patch.size(); ++j) product += patch[j] * here[j];
      sum += static_cast<double>(product);
      return true;
    };
    if (compare(0) && compare(1)) correlation[i] = 0.5 * sum;
  }
  return correlation;
}

}  // namespace ldp::sfm
