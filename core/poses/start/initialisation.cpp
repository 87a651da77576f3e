#include "core/poses/start/initialisation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include "core/poses/tracks/point_placement.h"

namespace ldp {
namespace {

constexpr double kAgreeing = 12;         // pixels of 800 within which a start explains an observation
constexpr double kClosing = 40;          // and by which a circle may miss its end before all steps share in that
constexpr double kRightSide = 0.5;       // of what the best explains must others explain
constexpr double kSurelyBeyond = -0.02;  // inverse distance of a point that is no point of a world right side out
constexpr int kCoarsePerFrame = 50;      // observations per frame that decide between focal lengths
constexpr size_t kFreed = 3;             // starts that are adjusted with free centres
constexpr double kNearTheSphere = 0.05;  // sigma of these: a short arc could turn inside out otherwise
constexpr double kSame = 0.02;           // starts whose focal lengths differ by less are one

FocalPrior anybodys_lens(const MatchedSweep& sweep) {
  return {0.9 * std::max(sweep.features[0].width, sweep.features[0].height), 0.5};
}

struct Start {
  Bundle bundle;
  double cost = std::numeric_limits<double>::infinity();
  size_t agreeing = 0, in_front = 0;  // observations
};

void adjust(Start& start, const BundleOptions& options, const Job& job) {
  const BundleSummary summary = adjust(start.bundle, options, job);
  start.cost = summary.usable && std::isfinite(summary.cost) ? summary.cost : std::numeric_limits<double>::infinity();
}

void sort_by_cost(std::vector<Start>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Start& a, const Start& b) { return a.cost < b.cost; });
}

// The best few, different ones.
std::vector<Start> best_of(std::vector<Start> candidates, size_t most) {
  sort_by_cost(candidates);
  std::vector<Start> chosen;
  for (Start& candidate : candidates) {
    const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Start& other) {
      return std::abs(std::log(candidate.bundle.lens.focal_px / other.bundle.lens.focal_px)) < kSame;
    });
    if (!known && chosen.size() < most) chosen.push_back(std::move(candidate));
  }
  return chosen;
}

// Whether most of a track's sightings, or half of them, do not agree with the others.
// Counts observations that agree, and those among them of points that do not lie beyond infinity: of a world inside out
// hardly any.
void count(const MatchedSweep& sweep, const std::vector<Track>& tracks, Start& start, const Job& job) {
  Bundle bundle = start.bundle;
  place_good(tracks, sweep.pixels(kAgreeing), false, bundle, job);
  start.agreeing = bundle.observations.size();
  start.in_front = static_cast<size_t>(
      std::count_if(bundle.observations.begin(), bundle.observations.end(), [&](const BundleObservation& o) {
        return bundle.points[static_cast<size_t>(o.point)].inverse_distance > kSurelyBeyond;
      }));
}

// Without those that explain little with points in front of the cameras. Cost does not ask for that: where little
// parallax shows, motion the other way round with the world inside out may cost less than the truth.
std::vector<Start> right_side_out(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                                  std::vector<Start> candidates, const Job& job) {
  size_t most = 0;
  for (Start& candidate : candidates) {
    count(sweep, tracks, candidate, job);
    most = std::max(most, candidate.agreeing);
  }
  std::erase_if(candidates, [&](const Start& candidate) {
    return static_cast<double>(candidate.agreeing) < kRightSide * static_cast<double>(most);
  });
  return candidates;
}

BundleOptions roughly(const MatchedSweep& sweep, const std::optional<FocalPrior>& prior) {
  BundleOptions options;
  options.focal_prior = prior.value_or(anybodys_lens(sweep));
  options.loss_px = sweep.pixels(kOffTheSphere);
  options.most_iterations = 30;
  return options;
}

// One start from each of the turns, finished by `finish` on one thread.
template <typename Finish>
std::vector<Start> starts_from(const std::vector<Turns>& turns, const Job& job, const Finish& finish) {
  std::vector<Start> candidates(turns.size());
  Job alone = job;
  alone.threads = 1;
  parallel_for(job, static_cast<int>(turns.size()), [&](int i) {
    const Turns& one = turns[static_cast<size_t>(i)];
    Start& start = candidates[static_cast<size_t>(i)];
    start.bundle.lens.focal_px = one.focal_px;
    for (const Eigen::Matrix3d& r : one.world_from_camera) start.bundle.cameras.push_back({r, r.col(2)});
    finish(start, alone);
  });
  return candidates;
}

// The best of all turns: on the sphere first, the best few of them then near it.
Start best_start(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
                 BundleOptions options, const Job& job) {
  Job alone = job;  // of each candidate
  alone.threads = 1;
  options.model = Model::spherical;
  std::vector<Start> candidates = starts_from(turns, job, [&](Start& start, const Job& own) {
    place_all(tracks, start.bundle);
    adjust(start, options, own);
  });
  candidates = best_of(right_side_out(sweep, tracks, std::move(candidates), job), kFreed);
  options.model = Model::free;
  parallel_for(job, static_cast<int>(candidates.size()),
               [&](int i) { adjust(candidates[static_cast<size_t>(i)], options, alone); });
  return std::move(best_of(right_side_out(sweep, tracks, std::move(candidates), job), 1).front());
}

}  // namespace

Bundle start(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
             const std::optional<FocalPrior>& prior, const Job& job) {
  const std::vector<Track> coarse = longest_tracks(tracks, sweep.frames(), kCoarsePerFrame);
  BundleOptions options = roughly(sweep, prior);
  options.arc_sigma = kNearTheSphere;
  Start best = best_start(sweep, coarse, turns, options, job);
  const size_t all = best.bundle.observations.size();
  if (static_cast<double>(best.in_front) > kRightSide * static_cast<double>(all)) return std::move(best.bundle);
  options.in_front = true;
  Start other = best_start(sweep, coarse, turns, options, job);
  return std::move(other.in_front > best.in_front ? other.bundle : best.bundle);
}

Bundle start_on_the_spot(const MatchedSweep& sweep, const std::vector<Track>& tracks, const std::vector<Turns>& turns,
                         const std::optional<FocalPrior>& prior, const Job& job) {
  const std::vector<Track> coarse = longest_tracks(tracks, sweep.frames(), kCoarsePerFrame);
  BundleOptions options = roughly(sweep, prior);
  options.model = Model::rotation;
  options.refine_distortion = true;
  Job alone = job;  // of each candidate
  alone.threads = 1;
  std::vector<Start> candidates = starts_from(turns, job, [&](Start& start, const Job& own) {
    for (Pose& pose : start.bundle.cameras) pose.centre.setZero();
    place_all(coarse, start.bundle);
    for (InversePoint& point : start.bundle.points) point.inverse_distance = 0;
    adjust(start, options, own);
  });
  candidates = best_of(std::move(candidates), kFreed);
  for (const double loss : {kClosing, kOffTheSphere}) {
    options.loss_px = sweep.pixels(loss);
    parallel_for(job, static_cast<int>(candidates.size()),
                 [&](int i) { adjust(candidates[static_cast<size_t>(i)], options, alone); });
  }
  Start best = std::move(best_of(std::move(candidates), 1).front());
  for (Pose& pose : best.bundle.cameras) pose.centre = pose.world_from_camera.col(2);
  return std::move(best.bundle);
}

}  // namespace ldp
