#include "core/poses/start/incremental_start.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include "core/poses/tracks/point_placement.h"

namespace ldp {
namespace {

constexpr double kTolerance = 4;          // pixels of 800
constexpr size_t kLeastShared = 15;       // points that a new frame must share with those already posed
constexpr size_t kCandidates = 12;        // pairs looked at for the beginning
constexpr double kWantedParallax = 0.05;  // radians, median of the pair's points, that make a good beginning
constexpr double kAnywhere = 1e3;         // sigma of the arc prior: only fixes what nothing else does
constexpr int kPerFrame = 100;            // observations per frame while frames are added
constexpr int kTellFocal = 5;             // frames from which the focal length is adjusted with them

Eigen::Matrix3d eigen(const cv::Mat& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result(i, j) = m.at<double>(i, j);
  }
  return result;
}

struct Pair {
  int a = 0, b = 0;
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double score = 0;
};

class Incremental {
 public:
  Incremental(const MatchedSweep& sweep, const std::vector<Track>& tracks, double focal, const FocalPrior& prior,
              const Job& job)
      : sweep_(sweep), tracks_(tracks), job_(job), prior_(prior) {
    start_.bundle.lens.focal_px = focal;
    start_.bundle.cameras.resize(static_cast<size_t>(sweep.frames()));
    start_.posed.assign(static_cast<size_t>(sweep.frames()), false);
  }

  std::optional<GeneralStart> run() {
    const Pair pair = beginning();
    if (pair.score <= 0) return std::nullopt;
    pose(pair.a, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
    pose(pair.b, pair.b_from_a, pair.translation);
    adjust_posed();
    while (add_next()) adjust_posed();
    return std::move(start_);
  }

 private:
  Bundle& bundle() { return start_.bundle; }
  cv::Matx33d camera() const {
    const double focal = start_.bundle.lens.focal_px;
    return {focal, 0, 0, 0, focal, 0, 0, 0, 1};
  }
  bool posed(int frame) const { return start_.posed[static_cast<size_t>(frame)]; }

  void pose(int frame, const Eigen::Matrix3d& camera_from_world, const Eigen::Vector3d& translation) {
    bundle().cameras[static_cast<size_t>(frame)] = {camera_from_world.transpose(),
                                                    -camera_from_world.transpose() * translation};
    start_.posed[static_cast<size_t>(frame)] = true;
  }

  // Of the pairs with most matches, the one with most points of good parallax.
  Pair beginning() const {
    std::vector<const PairMatches*> pairs;
    for (const PairMatches& pair : sweep_.pairs) pairs.push_back(&pair);
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const PairMatches* p, const PairMatches* q) { return p->matches.size() > q->matches.size(); });
    Pair best;
    // Neighbours have the most matches and the least parallax: look at every so many of the list, not at its head
    // alone.
    const size_t step = std::max<size_t>(1, pairs.size() / (2 * kCandidates));
    for (size_t i = 0; i < std::min(pairs.size(), kCandidates * step); i += step) {
      job_.check();
      const Pair pair = relative_pose(*pairs[i]);
      if (pair.score > best.score) best = pair;
    }
    return best;
  }

  Pair relative_pose(const PairMatches& matches) const {
    std::vector<cv::Point2d> in_a, in_b;
    for (const Match& m : matches.matches) {
      const Eigen::Vector2d p = sweep_.features[static_cast<size_t>(matches.a)].from_middle(m.a);
      const Eigen::Vector2d q = sweep_.features[static_cast<size_t>(matches.b)].from_middle(m.b);
      in_a.emplace_back(p.x(), p.y());
      in_b.emplace_back(q.x(), q.y());
    }
    cv::Mat mask, r, t;
    const cv::Mat e =
        cv::findEssentialMat(in_a, in_b, camera(), cv::RANSAC, 0.999, sweep_.pixels(0.5 * kTolerance), 500, mask);
    if (e.rows != 3 || e.cols != 3) return {};
    const int good = cv::recoverPose(e, in_a, in_b, camera(), r, t, mask);
    Pair pair{matches.a, matches.b, eigen(r), Eigen::Vector3d(t.at<double>(0), t.at<double>(1), t.at<double>(2)), 0};
    std::vector<double> parallax;
    const double focal = start_.bundle.lens.focal_px;
    for (size_t i = 0; i < in_a.size(); ++i) {
      if (mask.at<uchar>(static_cast<int>(i)) == 0) continue;
      const Eigen::Vector3d a = (pair.b_from_a * Eigen::Vector3d(in_a[i].x / focal, in_a[i].y / focal, 1)).normalized();
      const Eigen::Vector3d b = Eigen::Vector3d(in_b[i].x / focal, in_b[i].y / focal, 1).normalized();
      parallax.push_back(std::atan2(a.cross(b).norm(), a.dot(b)));
    }
    if (parallax.size() < 2 * kLeastShared) return {};
    std::nth_element(parallax.begin(), parallax.begin() + static_cast<std::ptrdiff_t>(parallax.size() / 2),
                     parallax.end());
    pair.score = good * std::min(1.0, parallax[parallax.size() / 2] / kWantedParallax);
    return pair;
  }

  // Tracks cut down to the posed frames.
  std::vector<Track> seen() const {
    std::vector<Track> result;
    for (const Track& track : tracks_) {
      Track part;
      std::copy_if(track.begin(), track.end(), std::back_inserter(part),
                   [&](const Observation& o) { return posed(o.frame); });
      if (part.size() >= 2) result.push_back(std::move(part));
    }
    return result;
  }

  void adjust_posed() {
    normalise();
    const std::vector<Track> chosen = longest_tracks(seen(), sweep_.frames(), kPerFrame);
    place_good(chosen, sweep_.pixels(3 * kTolerance), false, bundle(), job_);
    BundleOptions options;
    options.arc_sigma = kAnywhere;
    options.refine_focal = std::count(start_.posed.begin(), start_.posed.end(), true) >= kTellFocal;
    options.focal_prior = prior_;
    options.loss_px = sweep_.pixels(0.5 * kTolerance);
    options.most_iterations = 10;
    adjust(bundle(), options, job_);
  }

  void normalise() {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double count = 0, squared = 0;
    for (int i = 0; i < sweep_.frames(); ++i) {
      if (posed(i)) mean += bundle().cameras[static_cast<size_t>(i)].centre, ++count;
    }
    mean /= count;
    for (int i = 0; i < sweep_.frames(); ++i) {
      if (posed(i)) squared += (bundle().cameras[static_cast<size_t>(i)].centre - mean).squaredNorm() / count;
    }
    for (Pose& p : bundle().cameras) p.centre = (p.centre - mean) / std::max(std::sqrt(squared), 1e-12);
  }

  // The frame that shares most points with those posed, by perspective from points. False when none shares enough.
  bool add_next() {
    std::vector<std::vector<cv::Point3d>> points(start_.posed.size());
    std::vector<std::vector<cv::Point2d>> places(start_.posed.size());
    for (const Track& track : tracks_) {
      const auto waiting =
          std::any_of(track.begin(), track.end(), [&](const Observation& o) { return !posed(o.frame); });
      if (!waiting) continue;
      const std::optional<InversePoint> point = place(track);
      if (!point) continue;
      const Eigen::Vector3d p = point->direction / std::max(point->inverse_distance, 1e-3);
      for (const Observation& o : track) {
        if (posed(o.frame)) continue;
        points[static_cast<size_t>(o.frame)].emplace_back(p.x(), p.y(), p.z());
        places[static_cast<size_t>(o.frame)].emplace_back(o.position_px.x(), o.position_px.y());
      }
    }
    for (;;) {
      const auto most = std::max_element(points.begin(), points.end(),
                                         [](const auto& a, const auto& b) { return a.size() < b.size(); });
      if (most->size() < kLeastShared) return false;
      const size_t frame = static_cast<size_t>(most - points.begin());
      cv::Mat turn, translation, inliers, r;
      const bool found =
          cv::solvePnPRansac(points[frame], places[frame], camera(), cv::noArray(), turn, translation, false, 300,
                             static_cast<float>(sweep_.pixels(2 * kTolerance)), 0.999, inliers, cv::SOLVEPNP_EPNP);
      if (found && inliers.rows >= static_cast<int>(kLeastShared) / 2) {
        cv::Rodrigues(turn, r);
        pose(static_cast<int>(frame), eigen(r),
             {translation.at<double>(0), translation.at<double>(1), translation.at<double>(2)});
        return true;
      }
      points[frame].clear();
    }
  }

  std::optional<InversePoint> place(const Track& track) const {
    std::vector<Sighting> sightings;
    for (const Observation& o : track) {
      if (!posed(o.frame)) continue;
      const Pose& p = start_.bundle.cameras[static_cast<size_t>(o.frame)];
      sightings.push_back({p.world_from_camera.transpose(), p.centre, ray_of(o.position_px, start_.bundle.lens)});
    }
    if (sightings.size() < 2) return std::nullopt;
    std::vector<bool> used;
    return triangulate_point_robustly(sightings, sweep_.pixels(kTolerance) / start_.bundle.lens.focal_px, used);
  }

  const MatchedSweep& sweep_;
  const std::vector<Track>& tracks_;
  const Job& job_;
  FocalPrior prior_;
  GeneralStart start_;
};

struct Outcome {
  std::optional<GeneralStart> start;
  size_t held = 0;  // observations that agree
};

}  // namespace

std::optional<GeneralStart> general_start(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                          const std::optional<FocalPrior>& prior, double likely_focal_px,
                                          const Job& job) {
  const double longer = std::max(sweep.features[0].width, sweep.features[0].height);
  const FocalPrior weak = prior.value_or(FocalPrior{0.9 * longer, 0.5});
  std::vector<double> focals{0.55 * longer, 0.75 * longer, 1.0 * longer, 1.4 * longer};
  if (prior) focals = {0.9 * prior->focal_px, prior->focal_px, 1.1 * prior->focal_px};
  focals.push_back(likely_focal_px);
  std::vector<Outcome> outcomes(focals.size());
  Job alone = job;  // of each candidate
  alone.threads = 1;
  parallel_for(job, static_cast<int>(focals.size()), [&](int i) {
    Outcome& outcome = outcomes[static_cast<size_t>(i)];
    outcome.start = Incremental(sweep, tracks, focals[static_cast<size_t>(i)], weak, alone).run();
    if (!outcome.start) return;
    std::vector<Track> seen;
    for (Track track : tracks) {
      std::erase_if(track, [&](const Observation& o) { return !outcome.start->posed[static_cast<size_t>(o.frame)]; });
      if (track.size() >= 2) seen.push_back(std::move(track));
    }
    Bundle& bundle = outcome.start->bundle;
    BundleOptions options;
    options.arc_sigma = kAnywhere;
    options.focal_prior = weak;
    options.loss_px = sweep.pixels(0.5 * kTolerance);
    place_good(longest_tracks(seen, sweep.frames(), kPerFrame), sweep.pixels(3 * kTolerance), false, bundle, alone);
    adjust(bundle, options, alone);
    place_good(seen, sweep.pixels(kTolerance), false, bundle, alone);
    outcome.held = bundle.observations.size();
  });
  const auto best = std::max_element(outcomes.begin(), outcomes.end(),
                                     [](const Outcome& a, const Outcome& b) { return a.held < b.held; });
  return best->start;
}

}  // namespace ldp
