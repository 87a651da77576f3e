#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "core/poses/features/descriptor_matching.h"
#include "core/poses/features/features.h"
#include "core/poses/poses.h"
#include "core/poses/poses_tuning.h"
#include "core/poses/tracks/tracks.h"
#include "core/poses/tracks/triangulation.h"

namespace ldp {

using namespace sfm;

namespace {

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
    k.features = detect_features(make_grey_photo(frames.load(k.frame), kWorkingSide_px), FeatureOptions{});
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
    const double widest = std::cos(kKnownCameraOverlap * std::atan2(0.5 * std::hypot(k.width, k.height), k.fx));
    std::vector<std::pair<double, int>> by_angle;
    for (int b = 0; b < count; ++b) {
      const double cosine =
          pose.world_from_camera.col(2).dot(known[static_cast<size_t>(b)].camera.pose.world_from_camera.col(2));
      if (b != a && cosine > widest) by_angle.emplace_back(-cosine, b);
    }
    std::sort(by_angle.begin(), by_angle.end());
    for (size_t i = 0; i < std::min<size_t>(kKnownCameraNeighbours, by_angle.size()); ++i) {
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
  return point && normalised_error(*point, both[0]) < tolerance && normalised_error(*point, both[1]) < tolerance;
}

// With y and z of its axes turned round: what a camera of OpenCV's or COLMAP's axes becomes when it is read as
// OpenGL's.
KnownFrame turned(const KnownFrame& known) {
  KnownFrame other{known.frame, known.camera, {}, known.rays};
  other.camera.pose.world_from_camera *= Eigen::Vector3d(1, -1, -1).asDiagonal();
  return other;
}

double ray_tolerance(const KnownFrame& known) {
  return kKnownCameraTolerance * longer_side(known.camera.intrinsics) / known.camera.intrinsics.fx;
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

// Turned cameras agree with as many matches as good ones only where all look the same way.
void refuse_turned_axes(const Agreement& agreement) {
  if (agreement.matches < kMinJudgedMatches || agreement.agree_turned < kMinTurnedAgreement * agreement.matches ||
      agreement.agree > kMaxUprightShare * agreement.agree_turned)
    return;
  throw std::runtime_error(
      "the photos contradict the cameras given, and agree with them when y and z of their axes are turned round: they "
      "seem to be OpenCV's or COLMAP's (y down, z forward): a transforms.json has OpenGL's (y up, z back), so negate "
      "the "
      "second and third column of each transform_matrix");
}

std::string doubt(const Agreement& agreement) {
  const double share = agreement.agree / std::max(1.0, static_cast<double>(agreement.matches));
  if (agreement.matches < kMinJudgedMatches || share > kMinAgreement) return {};
  return "only " + std::to_string(static_cast<int>(100 * share)) + " % of what photos have in common agrees with the " +
         "cameras given: are they of these photos, uncropped, with the right focal length and lens?";
}

// Cameras at one place, or with everything far away: nothing moves by half a pixel.
bool is_pure_rotation(std::vector<double>& parallax_px, double spread) {
  if (parallax_px.empty()) return spread == 0;
  const auto high =
      parallax_px.begin() + static_cast<std::ptrdiff_t>(kStillQuantile * static_cast<double>(parallax_px.size() - 1));
  std::nth_element(parallax_px.begin(), high, parallax_px.end());
  return *high < kStillParallax_px;
}

// Where the cameras are: points are triangulated from here.
struct KnownSpace {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // their mean
  double spread = 0;                                 // the farthest from it
};

// What triangulation adds up by frame, and of all points.
struct Errors {
  std::vector<double> squared_px;   // by known frame, of its inliers
  std::vector<double> parallax_px;  // by point, over the cameras' spread
};

double spread_about(const std::vector<KnownFrame>& known, const Eigen::Vector3d& origin) {
  double spread = 0;
  for (const KnownFrame& k : known) spread = std::max(spread, (k.camera.pose.centre - origin).norm());
  return spread;
}

void begin_reports(const FrameSource& frames, std::vector<FrameReport>& reports) {
  reports.resize(static_cast<size_t>(frames.size()));
  for (int i = 0; i < frames.size(); ++i) {
    reports[static_cast<size_t>(i)].name = frames.name(i);
    reports[static_cast<size_t>(i)].left_out.cause = LeftOutCause::no_camera;
  }
}

// Takes the cameras over as they are; gives the features of each.
std::vector<Features> add_cameras(std::vector<KnownFrame>& known, Poses& poses) {
  std::vector<Features> features;
  for (KnownFrame& k : known) {
    FrameReport& report = poses.report.frames[static_cast<size_t>(k.frame)];
    report.posed = true;
    report.left_out = {};
    report.features = k.features.size();
    poses.cameras.push_back(k.camera);
    poses.frame_of_camera.push_back(k.frame);
    features.push_back(std::move(k.features));
  }
  return features;
}

// Triangulates the track with outlier rejection; nothing is added where no two sightings agree.
void add_point(const std::vector<KnownFrame>& known, const KnownSpace& space, const Track& track, Poses& poses,
               Errors& errors) {
  const auto frame_of = [&](const Observation& o) -> const KnownFrame& { return known[static_cast<size_t>(o.frame)]; };
  const auto report_of = [&](const Observation& o) -> FrameReport& {
    return poses.report.frames[static_cast<size_t>(frame_of(o).frame)];
  };
  std::vector<Sighting> sightings;
  for (const Observation& o : track) {
    sightings.push_back(sighting(frame_of(o), o.feature, space.origin));
    ++report_of(o).matches;
  }
  const KnownFrame& first = frame_of(track.front());
  const Intrinsics& k = first.camera.intrinsics;
  std::vector<bool> used;
  const auto point = triangulate_point_robustly(sightings, ray_tolerance(first), used);
  if (!point) return;
  errors.parallax_px.push_back(space.spread * point->inverse_distance * k.fx);
  const double largest = space.spread > 0 ? kMaxPointDistance * space.spread : kMaxPointDistance;
  ScenePoint scene{space.origin + point->direction / std::max(point->inverse_distance, 1 / largest), {}};
  std::vector<Eigen::Vector2d> seen;
  for (size_t i = 0; i < track.size(); ++i) {
    if (!used[i]) continue;
    scene.cameras.push_back(track[i].frame);
    seen.emplace_back(track[i].position_px + 0.5 * Eigen::Vector2d(k.width, k.height));
    ++report_of(track[i]).inliers;
    const double error_px = normalised_error(*point, sightings[i]) * frame_of(track[i]).camera.intrinsics.fx;
    errors.squared_px[static_cast<size_t>(track[i].frame)] += error_px * error_px;
  }
  poses.points.push_back(std::move(scene));
  poses.sightings.push_back(std::move(seen));
}

void report_errors(const std::vector<KnownFrame>& known, const std::vector<double>& squared_px, PosesReport& report) {
  int inliers = 0;
  double sum = 0;
  for (size_t i = 0; i < known.size(); ++i) {
    FrameReport& of_frame = report.frames[static_cast<size_t>(known[i].frame)];
    of_frame.reprojection_px = std::sqrt(squared_px[i] / std::max(of_frame.inliers, 1));
    inliers += of_frame.inliers;
    sum += squared_px[i];
  }
  report.reprojection_px = std::sqrt(sum / std::max(inliers, 1));
}

}  // namespace

Poses triangulate(const FrameSource& frames, const std::vector<Camera>& cameras, const PosesOptions&, const Job& job) {
  std::vector<KnownFrame> known = matched_by_name(frames, cameras);
  job.report("features", 0);
  find_features(frames, known, job);
  KnownSpace space;
  for (const KnownFrame& k : known) space.origin += k.camera.pose.centre / static_cast<double>(known.size());
  space.spread = spread_about(known, space.origin);

  job.report("matching", 0.6);
  std::vector<PairMatches> pairs = neighbours(known);
  const Agreement agreement = keep_agreeing(known, space.origin, pairs, job);
  refuse_turned_axes(agreement);

  Poses poses;
  poses.report.doubt = doubt(agreement);
  if (!poses.report.doubt.empty()) poses.report.doubt_kind = PoseDoubt::contradicted;
  begin_reports(frames, poses.report.frames);
  const std::vector<Features> features = add_cameras(known, poses);
  Errors errors{std::vector<double>(known.size(), 0), {}};
  for (const Track& track : build_tracks(features, pairs)) add_point(known, space, track, poses, errors);
  if (is_pure_rotation(errors.parallax_px, space.spread)) poses.report.motion = Motion::rotation;
  report_errors(known, errors.squared_px, poses.report);
  poses.report.points = static_cast<int>(poses.points.size());
  job.report("points", 1);
  return poses;
}

}  // namespace ldp
