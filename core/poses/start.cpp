#include "start.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ldp {
namespace {

constexpr double kAgreeing = 12;         // pixels of 800 within which a start explains an observation
constexpr double kClosing = 40;          // and by which a circle may miss its end before all steps share in that
constexpr double kRightSide = 0.5;       // of what the best explains must others explain
constexpr double kSurelyBeyond = -0.02;  // inverse distance of a point that is no point of a world right side out
constexpr int kCoarsePerFrame = 50;      // observations per frame that decide between focal lengths
constexpr double kGuess = 0.2;           // inverse distance of a point that cannot be triangulated yet
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
bool contradicted(const std::vector<bool>& used) {
  const size_t agreeing = static_cast<size_t>(std::count(used.begin(), used.end(), true));
  return used.size() > 2 && 2 * agreeing <= used.size();
}

}  // namespace

void add_point(const Track& track, const InversePoint& point, Bundle& bundle) {
  const int index = static_cast<int>(bundle.points.size());
  bundle.points.push_back(point);
  for (const Observation& o : track) bundle.observations.push_back({o.frame, index, o.position_px, o.weight});
}

std::vector<Track> longest_tracks(std::vector<Track> tracks, int frames, int per_frame) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.size() > b.size(); });
  std::vector<int> seen(static_cast<size_t>(frames), 0);
  std::vector<Track> chosen;
  for (const Track& track : tracks) {
    const bool wanted = std::any_of(track.begin(), track.end(), [&](const Observation& o) {
      return seen[static_cast<size_t>(o.frame)] < per_frame;
    });
    if (!wanted) continue;
    for (const Observation& o : track) ++seen[static_cast<size_t>(o.frame)];
    chosen.push_back(track);
  }
  return chosen;
}

void place_all(const std::vector<Track>& tracks, Bundle& bundle) {
  bundle.points.clear();
  bundle.observations.clear();
  for (const Track& track : tracks) {
    const std::vector<Sighting> s = sightings(track, bundle);
    std::optional<InversePoint> point = triangulate_point(s);
    if (!point || !believable(*point)) {
      const Sighting& middle = s[s.size() / 2];
      const Eigen::Vector3d ray = middle.camera_from_world.transpose() * middle.position.homogeneous().normalized();
      point = InversePoint{(ray + kGuess * middle.centre).normalized(), kGuess};
    }
    add_point(track, *point, bundle);
  }
}

std::vector<Track> place_good(const std::vector<Track>& tracks, double tolerance_px, bool at_infinity, Bundle& bundle,
                              const Job& job) {
  struct Placed {
    std::optional<InversePoint> point;
    std::vector<bool> used;
  };
  constexpr int kChunk = 128;
  std::vector<Placed> placed(tracks.size());
  parallel_for(job, (static_cast<int>(tracks.size()) + kChunk - 1) / kChunk, [&](int chunk) {
    const size_t begin = static_cast<size_t>(chunk) * kChunk, end = std::min(tracks.size(), begin + kChunk);
    for (size_t i = begin; i < end; ++i) {
      if (tracks[i].size() < 2) continue;
      placed[i].point = triangulate_point_robustly(sightings(tracks[i], bundle, at_infinity),
                                                   tolerance_px / bundle.lens.focal_px, placed[i].used);
    }
  });
  bundle.points.clear();
  bundle.observations.clear();
  std::vector<Track> kept;
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (!placed[i].point || !believable(*placed[i].point) || contradicted(placed[i].used)) continue;
    Track good;
    for (size_t j = 0; j < tracks[i].size(); ++j) {
      if (placed[i].used[j]) good.push_back(tracks[i][j]);
    }
    if (at_infinity) placed[i].point->inverse_distance = 0;
    add_point(good, *placed[i].point, bundle);
    kept.push_back(std::move(good));
  }
  return kept;
}

namespace {

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
