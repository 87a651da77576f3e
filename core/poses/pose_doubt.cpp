#include "core/poses/pose_doubt.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/poses/poses_tuning.h"
#include "core/poses/start/rotation_averaging.h"

namespace ldp::sfm {
namespace {

class Doubts {
 public:
  Doubts(const MatchedSweep& sweep, const Reconstruction& r, const std::vector<std::string>& names)
      : sweep_(sweep), r_(r), names_(names) {}

  // The pair of photos whose matches contradict the poses most.
  std::string contradicted() const {
    double least = kMinPairAgreement;
    const PairMatches* worst = nullptr;
    for (const PairMatches& pair : sweep_.pairs) {
      if (!neighbours(pair) || pair.matches.size() < kMinDoubtMatches) continue;
      const double share = agreeing(pair);
      if (share < least) least = share, worst = &pair;
    }
    if (!worst) return {};
    return "only " + std::to_string(std::lround(100 * least)) + " % of what matches in " + both(worst->a, worst->b) +
           " agrees with their poses: something repeats itself or moves";
  }

  double agreement() const {
    double agree = 0, all = 0;
    for (const PairMatches& pair : sweep_.pairs) {
      if (!neighbours(pair) || pair.matches.empty()) continue;
      const auto matches = static_cast<double>(pair.matches.size());
      agree += agreeing(pair) * matches;
      all += matches;
    }
    return all > 0 ? agree / all : 1;
  }

  // The place of the sequence that the fewest points bridge.
  std::string loose() const {
    std::vector<int> ties(static_cast<size_t>(sweep_.frames()), 0);
    for (const Track& track : r_.tracks) {
      for (size_t i = 0; i + 1 < track.size(); ++i) {
        if (track[i + 1].frame - track[i].frame > kBridgeSequenceDistance) continue;
        for (int f = track[i].frame + 1; f <= track[i + 1].frame; ++f) ++ties[static_cast<size_t>(f)];
      }
    }
    int least = kMinBridgingPoints, before = -1;
    std::pair<int, int> where{-1, -1};
    for (int f = 0; f < sweep_.frames(); ++f) {
      if (!posed(f)) continue;
      if (before >= 0 && ties[static_cast<size_t>(f)] < least)
        least = ties[static_cast<size_t>(f)], where = {before, f};
      before = f;
    }
    if (where.first < 0) return {};
    return "only " + std::to_string(least) + " points tie " + both(where.first, where.second) + " together, " +
           std::to_string(degrees(0.5 * (turned(where.first) + turned(where.second)))) +
           " degrees from the first: take photos with more overlap";
  }

  // A full turn whose last photos look where the first ones did, and hardly a point says how they lie to each other.
  std::string open_seam() const {
    std::vector<int> posed_frames;
    for (int f = 0; f < sweep_.frames(); ++f)
      if (posed(f)) posed_frames.push_back(f);
    if (posed_frames.size() < 2 || turned(posed_frames.back()) < kLeastFullTurn_rad) return {};
    const int first = posed_frames.front(), last = posed_frames.back();
    const double gap = angle(first, last);
    if (gap > kSeamOverlapAngle * view()) return {};
    const int ties = seam_ties(first, last);
    if (ties >= kMinBridgingPoints) return {};
    return "only " + std::to_string(ties) + " points tie " + both(last, first) + " together, where the turn closes (" +
           std::to_string(degrees(turned(last))) + " degrees from the first): go on past what the first photo shows";
  }

  // Steps between two photos each, that hardly a third photo compares: how long they are beside each other, and the
  // focal length, are then anyone's guess.
  std::string in_pairs(bool focal_known) const {
    if (r_.motion == Motion::rotation) return {};
    std::vector<int> between(static_cast<size_t>(sweep_.frames()), 0);
    for (const Track& track : r_.tracks) {
      for (size_t i = 1; i + 1 < track.size(); ++i) ++between[static_cast<size_t>(track[i].frame)];
    }
    int steps = -1, firm = 0;
    for (int f = 0; f < sweep_.frames(); ++f) {
      if (!posed(f)) continue;
      ++steps;
      firm += between[static_cast<size_t>(f)] >= kFirmlyObserved ? 1 : 0;
    }
    if (2 * firm >= steps - 1) return {};
    return std::string("hardly a point is seen in three photos: take photos with more overlap (three quarters)") +
           (focal_known ? "" : ", or give the field of view");
  }

  // A focal length that points left open, and that drifted to what no camera has.
  std::string no_lens(bool focal_known) const {
    const double view = view_of_longer_side(sweep_, r_.bundle.lens.focal_px);
    if (focal_known || (view > kMinView_rad && view < kMaxView_rad)) return {};
    return "they are those of a camera that sees " + std::to_string(std::lround(view * 180 / std::numbers::pi)) +
           " degrees, which hardly any does: give the field of view";
  }

  // Two photos of one view by their poses, that have nothing in common.
  std::string unrelated() const {
    const std::vector<std::vector<bool>> shared = shared_points();
    const double same_place = kSamePlaceShare * median_distance();
    for (int b = 0; b < sweep_.frames(); ++b) {
      for (int a = 0; a < b; ++a) {
        if (!posed(a) || !posed(b) || shared[static_cast<size_t>(a)][static_cast<size_t>(b)]) continue;
        const Pose &p = camera(a), &q = camera(b);
        const double cosine = p.world_from_camera.col(2).dot(q.world_from_camera.col(2));
        if (std::acos(std::clamp(cosine, -1.0, 1.0)) > kSameViewAngle * view()) continue;
        if (r_.motion != Motion::rotation && (p.centre - q.centre).norm() > same_place) continue;
        return both(a, b) + " look the same way by their poses and show nothing in common";
      }
    }
    return {};
  }

 private:
  static long degrees(double rad) { return std::lround(rad * 180 / std::numbers::pi); }
  double view() const { return 2 * std::atan2(0.5 * sweep_.features[0].width, r_.bundle.lens.focal_px); }
  double angle(int a, int b) const {
    return std::acos(std::clamp(camera(a).world_from_camera.col(2).dot(camera(b).world_from_camera.col(2)), -1.0, 1.0));
  }
  // From the first posed frame to this one, step by step.
  double turned(int frame) const {
    double sum = 0;
    int before = -1;
    for (int f = 0; f <= frame; ++f) {
      if (!posed(f)) continue;
      if (before >= 0) sum += angle(before, f);
      before = f;
    }
    return sum;
  }
  // Points seen in the first photos and in the last ones.
  int seam_ties(int first, int last) const {
    const auto ties = [&](const Track& track) {
      return track.front().frame <= first + kBridgeSequenceDistance &&
             track.back().frame >= last - kBridgeSequenceDistance;
    };
    return static_cast<int>(std::count_if(r_.tracks.begin(), r_.tracks.end(), ties));
  }
  bool posed(int frame) const { return !r_.left_out[static_cast<size_t>(frame)]; }
  bool neighbours(const PairMatches& pair) const {
    return posed(pair.a) && posed(pair.b) && pair.b - pair.a <= kDoubtSequenceDistance;
  }
  double agreeing(const PairMatches& pair) const {
    return inlier_ratio(sweep_, r_.bundle, pair, sweep_.pixels(kDoubtTolerance_px), r_.motion == Motion::rotation);
  }
  const Pose& camera(int frame) const { return r_.bundle.cameras[static_cast<size_t>(frame)]; }
  std::string both(int a, int b) const {
    return names_[static_cast<size_t>(a)] + " and " + names_[static_cast<size_t>(b)];
  }

  // Of the points, from the cameras' mean place.
  double median_distance() const {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (const Pose& pose : r_.bundle.cameras) place += pose.centre / static_cast<double>(r_.bundle.cameras.size());
    std::vector<double> inverse;
    for (const InversePoint& point : r_.bundle.points)
      inverse.push_back(std::max(point.inverse_distance / point.seen_from(place).norm(), 1e-6));
    if (inverse.empty()) return 0;
    const auto middle = inverse.begin() + static_cast<std::ptrdiff_t>(inverse.size() / 2);
    std::nth_element(inverse.begin(), middle, inverse.end());
    return 1 / *middle;
  }

  std::vector<std::vector<bool>> shared_points() const {
    const size_t count = static_cast<size_t>(sweep_.frames());
    std::vector<std::vector<bool>> shared(count, std::vector<bool>(count, false));
    for (const Track& track : r_.tracks) {
      for (const Observation& p : track) {
        for (const Observation& q : track) shared[static_cast<size_t>(p.frame)][static_cast<size_t>(q.frame)] = true;
      }
    }
    return shared;
  }

  const MatchedSweep& sweep_;
  const Reconstruction& r_;
  const std::vector<std::string>& names_;
};

}  // namespace

Doubt doubt(const MatchedSweep& sweep, const Reconstruction& reconstruction, const std::vector<std::string>& names,
            bool focal_known) {
  const Doubts doubts(sweep, reconstruction, names);
  const Doubt found[] = {{PoseDoubt::contradicted, doubts.contradicted()},
                         {PoseDoubt::unrelated, doubts.unrelated()},
                         {PoseDoubt::loose, doubts.loose()},
                         {PoseDoubt::loose, doubts.open_seam()},
                         {PoseDoubt::in_pairs, doubts.in_pairs(focal_known)},
                         {PoseDoubt::lens, doubts.no_lens(focal_known)}};
  for (const Doubt& one : found) {
    if (!one.text.empty()) return one;
  }
  return {};
}

double agreement(const MatchedSweep& sweep, const Reconstruction& reconstruction) {
  const std::vector<std::string> no_names;
  return Doubts(sweep, reconstruction, no_names).agreement();
}

}  // namespace ldp::sfm
