#include "core/poses/start/incremental_reconstruction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "core/poses/start/start_tuning.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

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

class IncrementalReconstruction {
 public:
  IncrementalReconstruction(const MatchedSweep& sweep, const std::vector<Track>& tracks, double focal,
                            const FocalPrior& prior, const Job& job)
      : sweep_(sweep), tracks_(tracks), job_(job), prior_(prior) {
    start_.bundle.lens.focal_px = focal;
    start_.bundle.cameras.resize(static_cast<size_t>(sweep.frames()));
    start_.posed.assign(static_cast<size_t>(sweep.frames()), false);
  }

  std::optional<IncrementalResult> run() {
    const Pair pair = initial_pair();
    if (pair.score <= 0) return std::nullopt;
    register_frame(pair.a, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
    register_frame(pair.b, pair.b_from_a, pair.translation);
    adjust_registered();
    while (register_next_frame()) adjust_registered();
    return std::move(start_);
  }

 private:
  Bundle& bundle() { return start_.bundle; }
  cv::Matx33d camera() const {
    const double focal = start_.bundle.lens.focal_px;
    return {focal, 0, 0, 0, focal, 0, 0, 0, 1};
  }
  bool posed(int frame) const { return start_.posed[static_cast<size_t>(frame)]; }

  void register_frame(int frame, const Eigen::Matrix3d& camera_from_world, const Eigen::Vector3d& translation) {
    bundle().cameras[static_cast<size_t>(frame)] = {camera_from_world.transpose(),
                                                    -camera_from_world.transpose() * translation};
    start_.posed[static_cast<size_t>(frame)] = true;
  }

  // Of the pairs with most matches, the one with most points of good parallax.
  Pair initial_pair() const {
    std::vector<const PairMatches*> pairs;
    for (const PairMatches& pair : sweep_.pairs) pairs.push_back(&pair);
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const PairMatches* p, const PairMatches* q) { return p->matches.size() > q->matches.size(); });
    Pair best;
    // Neighbours have the most matches and the least parallax: look at every so many of the list, not at its head
    // alone.
    const size_t step = std::max<size_t>(1, pairs.size() / (2 * kInitialPairCandidates));
    for (size_t i = 0; i < std::min(pairs.size(), kInitialPairCandidates * step); i += step) {
      job_.check();
      const Pair pair = relative_pose(*pairs[i]);
      if (pair.score > best.score) best = pair;
    }
    return best;
  }

  Pair relative_pose(const PairMatches& matches) const {
    std::vector<cv::Point2d> in_a, in_b;
    for (const Match& m : matches.matches) {
      const Eigen::Vector2d p = sweep_.features[static_cast<size_t>(matches.a)].centred(m.a);
      const Eigen::Vector2d q = sweep_.features[static_cast<size_t>(matches.b)].centred(m.b);
      in_a.emplace_back(p.x(), p.y());
      in_b.emplace_back(q.x(), q.y());
    }
    cv::Mat mask, r, t;
    const cv::Mat e = cv::findEssentialMat(in_a, in_b, camera(), cv::RANSAC, kIncrementalConfidence,
                                           sweep_.pixels(0.5 * kIncrementalTolerance_px), kEssentialIterations, mask);
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
    if (parallax.size() < 2 * kMinSharedPoints) return {};
    std::nth_element(parallax.begin(), parallax.begin() + static_cast<std::ptrdiff_t>(parallax.size() / 2),
                     parallax.end());
    pair.score = good * std::min(1.0, parallax[parallax.size() / 2] / kInitialPairParallax_rad);
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

  void adjust_registered() {
    normalise();
    const std::vector<Track> chosen = longest_tracks(seen(), sweep_, kIncrementalObservationsPerFrame);
    triangulate_inliers(chosen, sweep_.pixels(3 * kIncrementalTolerance_px), false, bundle(), job_);
    BundleAdjustmentOptions options;
    options.arc_sigma = kFreeArcSigma;
    options.refine_focal = std::count(start_.posed.begin(), start_.posed.end(), true) >= kMinFramesForFocal;
    options.focal_prior = prior_;
    options.loss_px = sweep_.pixels(0.5 * kIncrementalTolerance_px);
    options.max_iterations = kIncrementalAdjustmentSteps;
    adjust_bundle(bundle(), options, job_);
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
  bool register_next_frame() {
    std::vector<std::vector<cv::Point3d>> points(start_.posed.size());
    std::vector<std::vector<cv::Point2d>> places(start_.posed.size());
    for (const Track& track : tracks_) {
      const auto waiting =
          std::any_of(track.begin(), track.end(), [&](const Observation& o) { return !posed(o.frame); });
      if (!waiting) continue;
      const std::optional<InversePoint> point = triangulate(track);
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
      if (most->size() < kMinSharedPoints) return false;
      const size_t frame = static_cast<size_t>(most - points.begin());
      cv::Mat turn, translation, inliers, r;
      const bool found =
          cv::solvePnPRansac(points[frame], places[frame], camera(), cv::noArray(), turn, translation, false,
                             kPnpIterations, static_cast<float>(sweep_.pixels(2 * kIncrementalTolerance_px)),
                             kIncrementalConfidence, inliers, cv::SOLVEPNP_EPNP);
      if (found && inliers.rows >= static_cast<int>(kMinSharedPoints) / 2) {
        cv::Rodrigues(turn, r);
        register_frame(static_cast<int>(frame), eigen(r),
                       {translation.at<double>(0), translation.at<double>(1), translation.at<double>(2)});
        return true;
      }
      points[frame].clear();
    }
  }

  std::optional<InversePoint> triangulate(const Track& track) const {
    std::vector<Sighting> sightings;
    for (const Observation& o : track) {
      if (!posed(o.frame)) continue;
      const Pose& p = start_.bundle.cameras[static_cast<size_t>(o.frame)];
      sightings.push_back(
          {p.world_from_camera.transpose(), p.centre, undistorted_ray(o.position_px, start_.bundle.lens)});
    }
    if (sightings.size() < 2) return std::nullopt;
    std::vector<bool> used;
    return triangulate_point_robustly(sightings, sweep_.pixels(kIncrementalTolerance_px) / start_.bundle.lens.focal_px,
                                      used);
  }

  const MatchedSweep& sweep_;
  const std::vector<Track>& tracks_;
  const Job& job_;
  FocalPrior prior_;
  IncrementalResult start_;
};

struct Attempt {
  std::optional<IncrementalResult> start;
  size_t held = 0;  // observations that agree
};

}  // namespace

std::optional<IncrementalResult> reconstruct_incrementally(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                                           const std::optional<FocalPrior>& prior,
                                                           double likely_focal_px, const Job& job) {
  const double longer = std::max(sweep.features[0].width, sweep.features[0].height);
  const FocalPrior weak = prior.value_or(generic_focal_prior(sweep));
  std::vector<double> focals{0.55 * longer, 0.75 * longer, 1.0 * longer, 1.4 * longer};
  if (prior) focals = {0.9 * prior->focal_px, prior->focal_px, 1.1 * prior->focal_px};
  focals.push_back(likely_focal_px);
  std::vector<Attempt> attempts(focals.size());
  Job alone = job;  // of each candidate
  alone.threads = 1;
  parallel_for(job, static_cast<int>(focals.size()), [&](int i) {
    Attempt& attempt = attempts[static_cast<size_t>(i)];
    attempt.start = IncrementalReconstruction(sweep, tracks, focals[static_cast<size_t>(i)], weak, alone).run();
    if (!attempt.start) return;
    std::vector<Track> seen;
    for (Track track : tracks) {
      std::erase_if(track, [&](const Observation& o) { return !attempt.start->posed[static_cast<size_t>(o.frame)]; });
      if (track.size() >= 2) seen.push_back(std::move(track));
    }
    Bundle& bundle = attempt.start->bundle;
    BundleAdjustmentOptions options;
    options.arc_sigma = kFreeArcSigma;
    options.focal_prior = weak;
    options.loss_px = sweep.pixels(0.5 * kIncrementalTolerance_px);
    triangulate_inliers(longest_tracks(seen, sweep, kIncrementalObservationsPerFrame),
                        sweep.pixels(3 * kIncrementalTolerance_px), false, bundle, alone);
    adjust_bundle(bundle, options, alone);
    triangulate_inliers(seen, sweep.pixels(kIncrementalTolerance_px), false, bundle, alone);
    attempt.held = bundle.observations.size();
  });
  const auto best = std::max_element(attempts.begin(), attempts.end(),
                                     [](const Attempt& a, const Attempt& b) { return a.held < b.held; });
  return best->start;
}

}  // namespace ldp::sfm
