#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "core/poses/features/descriptor_matching.h"
#include "core/poses/features/features.h"
#include "core/poses/poses.h"
#include "core/poses/tracks/tracks.h"
#include "core/poses/tracks/triangulation.h"

namespace ldp {
namespace {

constexpr double kTolerance = 0.005;  // of the longer image side: given cameras may be a centimetre off
constexpr int kPicture_px = 1000;     // longer side of what is kept of a photo
constexpr int kNeighbours = 4;        // frames that each frame is matched with, nearest line of sight first
constexpr double kFarthest = 1e4;     // points are put no farther than this many spreads of the cameras

struct KnownFrame {
  int frame = 0;  // index in the source
  Camera camera;
  Features features;
  std::vector<Eigen::Vector2d> rays;  // undistorted, on the plane z = 1
};

double longer_side(const Intrinsics& k) { return std::max(k.width, k.height); }

std::vector<KnownFrame> matched_by_name(const FrameSource& frames, const std::vector<Camera>& cameras) {
  std::map<std::string, const Camera*> by_name;
  for (const Camera& camera : cameras) by_name[camera.name] = &camera;
  std::vector<KnownFrame> known;
  for (int i = 0; i < frames.size(); ++i) {
    const auto found = by_name.find(frames.name(i));
    if (found != by_name.end()) known.push_back({i, *found->second, {}, {}});
  }
  if (known.size() < 3) {
    throw Impossible("only " + std::to_string(known.size()) + " of " + std::to_string(frames.size()) +
                     " photos have a camera of the same name; at least 3 are needed");
  }
  return known;
}

void find_features(const FrameSource& frames, std::vector<KnownFrame>& known, const Job& job) {
  parallel_for(job, static_cast<int>(known.size()), [&](int i) {
    KnownFrame& k = known[static_cast<size_t>(i)];
    k.features = detect_features(make_grey_photo(frames.load(k.frame), kPicture_px), FeatureOptions{});
    for (const Eigen::Vector2d& p : k.features.positions) k.rays.push_back(unproject(k.camera.intrinsics, p).head<2>());
  });
}

std::vector<PairMatches> neighbours(const std::vector<KnownFrame>& known) {
  const int count = static_cast<int>(known.size());
  std::vector<std::vector<bool>> chosen(known.size(), std::vector<bool>(known.size(), false));
  std::vector<PairMatches> pairs;
  for (int a = 0; a < count; ++a) {
    const Pose& pose = known[static_cast<size_t>(a)].camera.pose;
    const Intrinsics& k = known[static_cast<size_t>(a)].camera.intrinsics;
    const double widest = std::cos(1.8 * std::atan2(0.5 * std::hypot(k.width, k.height), k.fx));
    std::vector<std::pair<double, int>> by_angle;
    for (int b = 0; b < count; ++b) {
      const double cosine =
          pose.world_from_camera.col(2).dot(known[static_cast<size_t>(b)].camera.pose.world_from_camera.col(2));
      if (b != a && cosine > widest) by_angle.emplace_back(-cosine, b);
    }
    std::sort(by_angle.begin(), by_angle.end());
    for (size_t i = 0; i < std::min<size_t>(kNeighbours, by_angle.size()); ++i) {
      const auto [low, high] = std::minmax(a, by_angle[i].second);
      if (chosen[static_cast<size_t>(low)][static_cast<size_t>(high)]) continue;
      chosen[static_cast<size_t>(low)][static_cast<size_t>(high)] = true;
      pairs.push_back({low, high, {}});
    }
  }
  return pairs;
}

Sighting sighting(const KnownFrame& known, int feature, const Eigen::Vector3d& origin) {
  return {known.camera.pose.world_from_camera.transpose(), known.camera.pose.centre - origin,
          known.rays[static_cast<size_t>(feature)]};
}

// Distance of a match from its epipolar geometry: that of the two sightings from the point nearest to both.
bool agrees(const KnownFrame& a, const KnownFrame& b, const Match& match, const Eigen::Vector3d& origin,
            double tolerance) {
  const std::vector<Sighting> both{sighting(a, match.a, origin), sighting(b, match.b, origin)};
  const std::optional<InversePoint> point = triangulate_point(both);
  return point && sighting_error(*point, both[0]) < tolerance && sighting_error(*point, both[1]) < tolerance;
}

// With y and z of its axes turned round: what a camera of OpenCV's or COLMAP's axes becomes when it is read as
// OpenGL's.
KnownFrame turned(const KnownFrame& known) {
  KnownFrame other{known.frame, known.camera, {}, known.rays};
  other.camera.pose.world_from_camera *= Eigen::Vector3d(1, -1, -1).asDiagonal();
  return other;
}

double ray_tolerance(const KnownFrame& known) {
  return kTolerance * longer_side(known.camera.intrinsics) / known.camera.intrinsics.fx;
}

// How many matches there are, how many agree with the cameras, and how many would with all of them turned.
struct Agreement {
  int matches = 0, agree = 0, agree_turned = 0;
};

// Keeps of all pairs' matches those that agree with the cameras.
Agreement keep_agreeing(const std::vector<KnownFrame>& known, const Eigen::Vector3d& origin,
                        std::vector<PairMatches>& pairs, const Job& job) {
  std::vector<Agreement> counts(pairs.size());
  parallel_for(job, static_cast<int>(pairs.size()), [&](int i) {
    PairMatches& pair = pairs[static_cast<size_t>(i)];
    Agreement& count = counts[static_cast<size_t>(i)];
    const KnownFrame &a = known[static_cast<size_t>(pair.a)], &b = known[static_cast<size_t>(pair.b)];
    const KnownFrame a_turned = turned(a), b_turned = turned(b);
    const double tolerance = ray_tolerance(a);
    for (const Match& match : match_features(a.features, b.features, MatchOptions{})) {
      ++count.matches;
      count.agree_turned += agrees(a_turned, b_turned, match, origin, tolerance) ? 1 : 0;
      if (agrees(a, b, match, origin, tolerance)) pair.matches.push_back(match);
    }
    count.agree = static_cast<int>(pair.matches.size());
  });
  Agreement sum;
  for (const Agreement& count : counts) {
    sum.matches += count.matches;
    sum.agree += count.agree;
    sum.agree_turned += count.agree_turned;
  }
  return sum;
}

constexpr int kFewest = 50;  // matches, below which nothing is said of the cameras

// Good cameras agree with 0.7 to 0.98 of the matches, turned ones with more than 0.8 of those only where all look the
// same way.
void refuse_turned_axes(const Agreement& agreement) {
  if (agreement.matches < kFewest || 2 * agreement.agree_turned < agreement.matches ||
      agreement.agree > 0.8 * agreement.agree_turned)
    return;
  throw std::runtime_error(
      "the photos contradict the cameras given, and agree with them when y and z of their axes are turned round: they "
      "seem to be OpenCV's or COLMAP's (y down, z forward): a transforms.json has OpenGL's (y up, z back), so negate "
      "the "
      "second and third column of each transform_matrix");
}

std::string doubt(const Agreement& agreement) {
  const double share = agreement.agree / std::max(1.0, static_cast<double>(agreement.matches));
  if (agreement.matches < kFewest || share > 0.25) return {};
  return "only " + std::to_string(static_cast<int>(100 * share)) + " % of what photos have in common agrees with the " +
         "cameras given: are they of these photos, uncropped, with the right focal length and lens?";
}

// Cameras at one place, or with everything far away: nothing moves by half a pixel.
bool only_turned(std::vector<double>& parallax_px, double spread) {
  if (parallax_px.empty()) return spread == 0;
  const auto high =
      parallax_px.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(parallax_px.size() - 1));
  std::nth_element(parallax_px.begin(), high, parallax_px.end());
  return *high < 0.5;
}

}  // namespace

Poses triangulate(const FrameSource& frames, const std::vector<Camera>& cameras, const PosesOptions&, const Job& job) {
  std::vector<KnownFrame> known = matched_by_name(frames, cameras);
  job.report("features", 0);
  find_features(frames, known, job);
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (const KnownFrame& k : known) origin += k.camera.pose.centre / static_cast<double>(known.size());
  double spread = 0;
  for (const KnownFrame& k : known) spread = std::max(spread, (k.camera.pose.centre - origin).norm());

  job.report("matching", 0.6);
  std::vector<PairMatches> pairs = neighbours(known);
  const Agreement agreement = keep_agreeing(known, origin, pairs, job);
  refuse_turned_axes(agreement);

  Poses poses;
  poses.report.doubt = doubt(agreement);
  poses.report.frames.resize(static_cast<size_t>(frames.size()));
  for (int i = 0; i < frames.size(); ++i) {
    poses.report.frames[static_cast<size_t>(i)].name = frames.name(i);
    poses.report.frames[static_cast<size_t>(i)].reason = "no camera was given for it";
  }
  std::vector<Features> features;
  std::vector<double> squared(known.size(), 0), parallax_px;
  for (KnownFrame& k : known) {
    FrameReport& report = poses.report.frames[static_cast<size_t>(k.frame)];
    report.posed = true;
    report.reason.clear();
    report.features = k.features.size();
    poses.cameras.push_back(k.camera);
    poses.frame_of_camera.push_back(k.frame);
    features.push_back(std::move(k.features));
  }
  const double largest = spread > 0 ? kFarthest * spread : kFarthest;
  for (const Track& track : build_tracks(features, pairs)) {
    std::vector<Sighting> sightings;
    for (const Observation& o : track) {
      sightings.push_back(sighting(known[static_cast<size_t>(o.frame)], o.feature, origin));
      ++poses.report.frames[static_cast<size_t>(known[static_cast<size_t>(o.frame)].frame)].matches;
    }
    const KnownFrame& first = known[static_cast<size_t>(track.front().frame)];
    const Intrinsics& k = first.camera.intrinsics;
    std::vector<bool> used;
    const auto point = triangulate_point_robustly(sightings, ray_tolerance(first), used);
    if (!point) continue;
    parallax_px.push_back(spread * point->inverse_distance * k.fx);
    ScenePoint scene{origin + point->direction / std::max(point->inverse_distance, 1 / largest), {}};
    std::vector<Eigen::Vector2d> seen;
    for (size_t i = 0; i < track.size(); ++i) {
      if (!used[i]) continue;
      const size_t camera = static_cast<size_t>(track[i].frame);
      scene.cameras.push_back(track[i].frame);
      seen.emplace_back(track[i].position_px + 0.5 * Eigen::Vector2d(k.width, k.height));
      ++poses.report.frames[static_cast<size_t>(known[camera].frame)].inliers;
      const double error_px = sighting_error(*point, sightings[i]) * known[camera].camera.intrinsics.fx;
      squared[camera] += error_px * error_px;
    }
    poses.points.push_back(std::move(scene));
    poses.sightings.push_back(std::move(seen));
  }
  if (only_turned(parallax_px, spread)) poses.report.motion = Motion::rotation;
  int inliers = 0;
  double sum = 0;
  for (size_t i = 0; i < known.size(); ++i) {
    FrameReport& report = poses.report.frames[static_cast<size_t>(known[i].frame)];
    report.reprojection_px = std::sqrt(squared[i] / std::max(report.inliers, 1));
    inliers += report.inliers;
    sum += squared[i];
  }
  poses.report.reprojection_px = std::sqrt(sum / std::max(inliers, 1));
  poses.report.points = static_cast<int>(poses.points.size());
  job.report("points", 1);
  return poses;
}

}  // namespace ldp
