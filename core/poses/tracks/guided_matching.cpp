#include "core/poses/tracks/guided_matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

double squared_distance(const int16_t* a, const int16_t* b) {
  int sum = 0;
  for (int i = 0; i < kDescriptorLength; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// Features of a frame on the plane z = 1, and their order from top to bottom.
struct Rays {
  std::vector<Eigen::Vector2d> positions;
  std::vector<int> by_height;
};

struct Segment {
  Eigen::Vector2d from, to;

  double distance(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d along = to - from;
    const double t = std::clamp((p - from).dot(along) / std::max(along.squaredNorm(), 1e-18), 0.0, 1.0);
    return (p - from - t * along).norm();
  }
};

class GuidedMatcher {
 public:
  GuidedMatcher(const MatchedSweep& sweep, const Bundle& bundle) : sweep_(sweep), bundle_(bundle) {
    for (const Features& features : sweep.features) {
      Rays rays;
      for (int i = 0; i < features.size(); ++i)
        rays.positions.push_back(undistorted_ray(features.centred(i), bundle.lens));
      rays.by_height.resize(rays.positions.size());
      std::iota(rays.by_height.begin(), rays.by_height.end(), 0);
      std::stable_sort(rays.by_height.begin(), rays.by_height.end(), [&](int p, int q) {
        return rays.positions[static_cast<size_t>(p)].y() < rays.positions[static_cast<size_t>(q)].y();
      });
      rays_.push_back(std::move(rays));
    }
  }

  bool overlap(int a, int b) const {
    const double view = 2 * std::atan2(0.5 * sweep_.features[0].width, bundle_.lens.focal_px);
    const double cosine = camera(a).world_from_camera.col(2).dot(camera(b).world_from_camera.col(2));
    return std::acos(std::clamp(cosine, -1.0, 1.0)) < kMaxGuidedAngle * view;
  }

  // The best match of every feature of a, each feature of b at most once.
  std::vector<Match> match(int a, int b) const {
    std::map<int, Match> of_b;
    for (int i = 0; i < sweep_.features[static_cast<size_t>(a)].size(); ++i) {
      const std::optional<Match> m = best_on_epipolar_line(a, i, b);
      if (!m) continue;
      const auto [place, added] = of_b.try_emplace(m->b, *m);
      if (!added && m->distance < place->second.distance) place->second = *m;
    }
    std::vector<Match> matches;
    for (const auto& [feature, m] : of_b) matches.push_back(m);
    return matches;
  }

 private:
  const Pose& camera(int frame) const { return bundle_.cameras[static_cast<size_t>(frame)]; }

  // The epipolar line in b of a feature of a, from kMinGuidedDepth to infinity.
  std::optional<Segment> epipolar_segment(int a, int feature, int b) const {
    const Eigen::Matrix3d b_from_a = camera(b).world_from_camera.transpose() * camera(a).world_from_camera;
    const Eigen::Vector3d shift = camera(b).world_from_camera.transpose() * (camera(a).centre - camera(b).centre);
    const Eigen::Vector3d far =
        b_from_a * rays_[static_cast<size_t>(a)].positions[static_cast<size_t>(feature)].homogeneous();
    const Eigen::Vector3d near = far + shift / kMinGuidedDepth;
    if (far.z() < 0.1 || near.z() < 0.1) return std::nullopt;
    return Segment{near.hnormalized(), far.hnormalized()};
  }

  std::optional<Match> best_on_epipolar_line(int a, int feature, int b) const {
    const std::optional<Segment> line = epipolar_segment(a, feature, b);
    if (!line) return std::nullopt;
    const double pixel = sweep_.pixels(1) / bundle_.lens.focal_px, band = kEpipolarBand_px * pixel;
    const Rays& rays = rays_[static_cast<size_t>(b)];
    const auto height = [&](int i) { return rays.positions[static_cast<size_t>(i)].y(); };
    auto i =
        std::lower_bound(rays.by_height.begin(), rays.by_height.end(), std::min(line->from.y(), line->to.y()) - band,
                         [&](int p, double y) { return height(p) < y; });
    const double bottom = std::max(line->from.y(), line->to.y()) + band;
    const int16_t* wanted = sweep_.features[static_cast<size_t>(a)].descriptor(feature);
    std::vector<std::pair<double, int>> likes;
    for (; i != rays.by_height.end() && height(*i) <= bottom; ++i) {
      if (line->distance(rays.positions[static_cast<size_t>(*i)]) > band) continue;
      likes.emplace_back(squared_distance(wanted, sweep_.features[static_cast<size_t>(b)].descriptor(*i)), *i);
    }
    if (likes.empty()) return std::nullopt;
    const auto best = *std::min_element(likes.begin(), likes.end());
    const double most = kMaxDescriptorDistance * kDescriptorNorm;
    if (best.first > most * most) return std::nullopt;
    for (const auto& [distance, other] : likes) {
      const bool twin =
          (rays.positions[static_cast<size_t>(other)] - rays.positions[static_cast<size_t>(best.second)]).norm() <
          kTwinFeature_px * pixel;
      if (!twin && best.first > kGuidedRatio * kGuidedRatio * distance) return std::nullopt;
    }
    return Match{feature, best.second, static_cast<int>(best.first)};
  }

  const MatchedSweep& sweep_;
  const Bundle& bundle_;
  std::vector<Rays> rays_;
};

// What was known already stays, unless it speaks of a feature that was matched anew.
void merge_matches(const std::vector<Match>& known, std::vector<Match>& matches) {
  std::vector<int> in_a, in_b;
  for (const Match& m : matches) in_a.push_back(m.a), in_b.push_back(m.b);
  std::sort(in_a.begin(), in_a.end());
  std::sort(in_b.begin(), in_b.end());
  for (const Match& m : known) {
    if (std::binary_search(in_a.begin(), in_a.end(), m.a) || std::binary_search(in_b.begin(), in_b.end(), m.b))
      continue;
    matches.push_back(m);
  }
}

}  // namespace

std::vector<PairMatches> match_guided(const MatchedSweep& sweep, const Bundle& bundle,
                                      const std::vector<LeftOut>& left_out, const Job& job) {
  const GuidedMatcher matcher(sweep, bundle);
  std::vector<PairMatches> pairs = sweep.pairs;
  std::map<std::pair<int, int>, size_t> place;
  for (size_t i = 0; i < pairs.size(); ++i) place[{pairs[i].a, pairs[i].b}] = i;
  for (int b = 1; b < sweep.frames(); ++b) {
    for (int a = 0; a < b; ++a) {
      if (left_out[static_cast<size_t>(a)] || left_out[static_cast<size_t>(b)]) continue;
      if (matcher.overlap(a, b) && place.try_emplace({a, b}, pairs.size()).second) pairs.push_back({a, b, {}});
    }
  }
  parallel_for(job, static_cast<int>(pairs.size()), [&](int i) {
    PairMatches& pair = pairs[static_cast<size_t>(i)];
    if (left_out[static_cast<size_t>(pair.a)] || left_out[static_cast<size_t>(pair.b)]) return;
    std::vector<Match> matches = matcher.match(pair.a, pair.b);
    merge_matches(pair.matches, matches);
    pair.matches = std::move(matches);
  });
  return pairs;
}

}  // namespace ldp::sfm
