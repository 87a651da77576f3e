#include "core/poses/tracks/match_graph.h"

#include <algorithm>
#include <utility>

namespace ldp::sfm {

std::vector<Track> longest_tracks(std::vector<Track> tracks, const MatchedSweep& sweep, int per_frame) {
  return longest_tracks(std::move(tracks), sweep.features, per_frame, sweep.track_grid);
}

double MatchedSweep::pixels(double of_800) const {
  return of_800 * std::max(features[0].width, features[0].height) / 800;
}

bool is_plausible(const InversePoint& point, double nearest) {
  return point.inverse_distance < nearest && point.inverse_distance > kMinInverseDistance;
}

// With all cameras in one place, every point is found at infinity.
std::vector<Sighting> sightings(const Track& track, const Bundle& bundle, bool at_infinity) {
  std::vector<Sighting> result;
  for (const Observation& o : track) {
    const Pose& pose = bundle.cameras[static_cast<size_t>(o.frame)];
    result.push_back({pose.world_from_camera.transpose(), at_infinity ? Eigen::Vector3d::Zero().eval() : pose.centre,
                      undistorted_ray(o.position_px, bundle.lens)});
  }
  return result;
}

std::vector<bool> inlier_matches(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair,
                                 double tolerance_px, bool at_infinity, double nearest) {
  const auto observation = [&](int frame, int feature) {
    return Observation{frame, feature, sweep.features[static_cast<size_t>(frame)].centred(feature)};
  };
  const double tolerance = tolerance_px / bundle.lens.focal_px;
  std::vector<bool> agrees;
  for (const Match& match : pair.matches) {
    const Track both{observation(pair.a, match.a), observation(pair.b, match.b)};
    const std::vector<Sighting> s = sightings(both, bundle, at_infinity);
    const std::optional<InversePoint> point = triangulate_point(s);
    agrees.push_back(point && is_plausible(*point, nearest) && normalised_error(*point, s[0]) < tolerance &&
                     normalised_error(*point, s[1]) < tolerance);
  }
  return agrees;
}

double inlier_ratio(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair, double tolerance_px,
                    bool at_infinity) {
  const std::vector<bool> agrees = inlier_matches(sweep, bundle, pair, tolerance_px, at_infinity);
  return static_cast<double>(std::count(agrees.begin(), agrees.end(), true)) / static_cast<double>(agrees.size());
}

}  // namespace ldp::sfm
