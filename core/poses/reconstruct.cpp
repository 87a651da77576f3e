#include "reconstruct.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "spherical.h"

namespace ldp {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kUnit = 1.0 / 800;  // tolerances are in pixels of a photo 800 pixels long
constexpr double kSpherical = 4;     // hands leave the sphere: jitter shows as so many pixels
constexpr int kHypotheses = 10;      // focal lengths tried when nothing is known
constexpr double kWidestView = 105 * kDegree, kNarrowestView = 18 * kDegree;  // of the longer side
constexpr size_t kRaysPerPair = 120;                                          // matches that vote for a pair's rotation
constexpr int kCoarsePerFrame = 60;  // observations per frame that decide between focal lengths
constexpr double kLeastW = 0.2;      // inverse distance given to a coarse point that cannot be triangulated yet

struct View {
  int width = 0, height = 0;
  double longer() const { return std::max(width, height); }
  double pixels(double units) const { return units * kUnit * longer(); }
  Eigen::Vector2d centred(const Eigen::Vector2d& p) const { return p - Eigen::Vector2d(0.5 * width, 0.5 * height); }
};

std::vector<RayPair> ray_pairs(const Sweep& sweep, const PairMatches& pair, const View& view, double focal) {
  std::vector<RayPair> rays;
  const size_t step = std::max<size_t>(1, pair.matches.size() / kRaysPerPair);
  for (size_t i = 0; i < pair.matches.size(); i += step) {
    const Match& m = pair.matches[i];
    rays.push_back(
        {view.centred(sweep.features[static_cast<size_t>(pair.a)].positions[static_cast<size_t>(m.a)]) / focal,
         view.centred(sweep.features[static_cast<size_t>(pair.b)].positions[static_cast<size_t>(m.b)]) / focal});
  }
  return rays;
}

std::vector<RotationEdge> rotation_edges(const Sweep& sweep, const View& view, double focal) {
  std::vector<RotationEdge> edges;
  for (const PairMatches& pair : sweep.pairs) {
    const RelativeRotation r = spherical_rotation(ray_pairs(sweep, pair, view, focal), view.pixels(kSpherical) / focal);
    edges.push_back({pair.a, pair.b, r.b_from_a, static_cast<double>(pair.matches.size()) * std::exp(-r.cost)});
  }
  return edges;
}

// Positions undistorted to the plane z = 1.
Eigen::Vector2d ray_of(const Eigen::Vector2d& position_px, const Lens& lens) {
  const Intrinsics k{0, 0, lens.focal_px, lens.focal_px, 0, 0, lens.k1, lens.k2, 0, 0};
  return unproject(k, position_px).head<2>();
}

// Longest tracks first, until every frame has its share.
std::vector<Track> coarse_tracks(std::vector<Track> tracks, size_t frames) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.size() > b.size(); });
  std::vector<int> seen(frames, 0);
  std::vector<Track> chosen;
  for (const Track& track : tracks) {
    const bool wanted = std::any_of(track.begin(), track.end(), [&](const Observation& o) {
      return seen[static_cast<size_t>(o.frame)] < kCoarsePerFrame;
    });
    if (!wanted) continue;
    for (const Observation& o : track) ++seen[static_cast<size_t>(o.frame)];
    chosen.push_back(track);
  }
  return chosen;
}

class Builder {
 public:
  Builder(const Sweep& sweep, const View& view) : sweep_(sweep), view_(view) {}

  Eigen::Vector2d position(const Observation& o) const {
    return view_.centred(sweep_.features[static_cast<size_t>(o.frame)].positions[static_cast<size_t>(o.feature)]);
  }

  std::vector<Sighting> sightings(const Track& track, const Bundle& bundle) const {
    std::vector<Sighting> result;
    for (const Observation& o : track) {
      const Pose& pose = bundle.cameras[static_cast<size_t>(o.frame)];
      result.push_back({pose.world_from_camera.transpose(), pose.centre, ray_of(position(o), bundle.lens)});
    }
    return result;
  }

  // Every track becomes a point, well or badly.
  void place_all(const std::vector<Track>& tracks, Bundle& bundle) const {
    bundle.points.clear();
    bundle.observations.clear();
    for (const Track& track : tracks) {
      const std::vector<Sighting> s = sightings(track, bundle);
      std::optional<InversePoint> point = triangulate_point(s);
      if (!point || std::abs(point->inverse_distance) > 5) {
        const Sighting& middle = s[s.size() / 2];
        const Eigen::Vector3d bearing =
            middle.camera_from_world.transpose() * middle.position.homogeneous().normalized();
        point = InversePoint{(bearing + kLeastW * middle.centre).normalized(), kLeastW};
      }
      add(track, *point, bundle);
    }
  }

  // Only what agrees: tracks lose observations farther off than the tolerance, or go altogether.
  std::vector<Track> place_good(const std::vector<Track>& tracks, double tolerance_px, Bundle& bundle) const {
    bundle.points.clear();
    bundle.observations.clear();
    std::vector<Track> kept;
    for (const Track& track : tracks) {
      std::vector<bool> used;
      const auto point =
          triangulate_point_robustly(sightings(track, bundle), tolerance_px / bundle.lens.focal_px, used);
      if (!point) continue;
      Track good;
      for (size_t i = 0; i < track.size(); ++i) {
        if (used[i]) good.push_back(track[i]);
      }
      add(good, *point, bundle);
      kept.push_back(std::move(good));
    }
    return kept;
  }

 private:
  void add(const Track& track, const InversePoint& point, Bundle& bundle) const {
    const int index = static_cast<int>(bundle.points.size());
    bundle.points.push_back(point);
    for (const Observation& o : track) bundle.observations.push_back({o.frame, index, position(o)});
  }

  const Sweep& sweep_;
  View view_;
};

std::vector<double> focal_hypotheses(const View& view, const std::optional<FocalPrior>& prior) {
  std::vector<double> focals;
  if (prior) {
    for (const double factor : {0.8, 0.9, 1.0, 1.1, 1.25}) focals.push_back(factor * prior->focal_px);
    return focals;
  }
  const double shortest = 0.5 * view.longer() / std::tan(0.5 * kWidestView);
  const double longest = 0.5 * view.longer() / std::tan(0.5 * kNarrowestView);
  for (int i = 0; i < kHypotheses; ++i)
    focals.push_back(shortest * std::pow(longest / shortest, i / (kHypotheses - 1.0)));
  return focals;
}

struct Start {
  Bundle bundle;
  double cost = std::numeric_limits<double>::infinity();
};

}  // namespace

Reconstruction reconstruct(const Sweep& sweep, const ReconstructOptions& options, const Job& job) {
  const View view{sweep.features.front().width, sweep.features.front().height};
  const Builder builder(sweep, view);
  const std::vector<Track> all = build_tracks(sweep.features, sweep.pairs);
  const size_t frames = sweep.features.size();
  const std::vector<Track> coarse = coarse_tracks(all, frames);
  BundleOptions adjusting;
  adjusting.spherical = true;
  adjusting.focal_prior = options.focal;
  adjusting.loss_px = view.pixels(kSpherical);

  const std::vector<double> focals = focal_hypotheses(view, options.focal);
  std::vector<Start> starts(focals.size());
  std::vector<bool> reached;
  parallel_for(job, static_cast<int>(focals.size()), [&](int i) {
    Start& start = starts[static_cast<size_t>(i)];
    const double focal = focals[static_cast<size_t>(i)];
    const std::vector<RotationEdge> edges = rotation_edges(sweep, view, focal);
    std::vector<bool> mine;
    const auto rotations = average_rotations(static_cast<int>(frames), static_cast<int>(frames) / 2, edges, mine);
    start.bundle.lens.focal_px = focal;
    for (const Eigen::Matrix3d& r : rotations) start.bundle.cameras.push_back({r, r.col(2)});
    builder.place_all(coarse, start.bundle);
    BundleOptions fixed = adjusting;
    fixed.refine_focal = false;
    fixed.most_iterations = 15;
    start.cost = adjust(start.bundle, fixed, job).cost;
    fixed.refine_focal = true;
    fixed.most_iterations = 30;
    start.cost = adjust(start.bundle, fixed, job).cost;
  });
  size_t best = 0;
  for (size_t i = 0; i < starts.size(); ++i) {
    if (starts[i].cost < starts[best].cost) best = i;
  }

  Reconstruction result;
  result.bundle = starts[best].bundle;
  result.posed.assign(frames, true);
  adjusting.spherical = false;
  adjusting.refine_distortion = true;
  for (const double tolerance : {12.0, 5.0, 3.0}) {
    result.tracks = builder.place_good(all, view.pixels(tolerance), result.bundle);
    adjusting.loss_px = view.pixels(tolerance / 3);
    adjust(result.bundle, adjusting, job);
  }
  return result;
}

}  // namespace ldp
