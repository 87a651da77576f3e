#include "core/poses/refine/iterative_refinement.h"

#include <algorithm>
#include <cmath>

#include "core/poses/adjust/depth_outliers.h"
#include "core/poses/adjust/distortion_model.h"
#include "core/poses/adjust/robust_tracks.h"
#include "core/poses/tracks/point_placement.h"

namespace ldp {
namespace {

constexpr double kLossOfTolerance = 0.3, kLargestLoss = 0.8;  // pixels of 800
constexpr double kFollowedLoss = 0.7;  // of that, on followed points: most are far better than the few that are not
constexpr double kMatchedPairs = 0.2, kFollowedPairs = 0.05;  // weights of points that two photos see, in the rounds
                                                              // before the last: some move, and two photos of what
                                                              // moves agree on cameras that a third tells wrong
constexpr double kRough = 1e-4, kFiner = 1e-5, kFine = 1e-6;  // where rounds end: those whose points the next places
                                                              // anew, those before points are followed, and the last
constexpr double kTrackLoss = 1;      // pixels of 800, of what is left of a whole track in the last round
constexpr double kLeastNoise = 0.01;  // pixels of 800: nothing is seen more exactly
constexpr double kLoner = 12;         // pixels of 800 of parallax that a point of two photos may differ from all around

bool is_followed(double tolerance) { return tolerance == kFollowed[0] || tolerance == kFollowed[1]; }

}  // namespace

std::vector<int> observations_by_frame(const Reconstruction& r) {
  std::vector<int> held(r.dropped.size(), 0);
  for (const BundleObservation& o : r.bundle.observations) ++held[static_cast<size_t>(o.camera)];
  return held;
}

double scatter_about_arc(const Reconstruction& r) {
  const std::vector<int> held = observations_by_frame(r);
  double squared = 0, numbers = 0;
  for (size_t i = 0; i < held.size(); ++i) {
    if (held[i] == 0) continue;
    const Pose& pose = r.bundle.cameras[i];
    squared += (pose.centre - pose.world_from_camera.col(2)).squaredNorm();
    numbers += 3;
  }
  return std::sqrt(squared / std::max(numbers, 1.0));
}

Rounds::Rounds(const MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job)
    : sweep_(&sweep), job_(job) {
  options_.focal_prior = focal;
}

void Rounds::round(const std::vector<Track>& tracks, double tolerance, double arc_sigma, Reconstruction& r) {
  place(tracks, tolerance, r);
  if (tolerance <= kFollowed[0] && options_.model != Model::rotation) leave_out_loners(r);
  const double loss = sweep_->pixels(std::min(kLossOfTolerance * tolerance, kLargestLoss));
  options_.loss_px = (is_followed(tolerance) ? kFollowedLoss : 1) * loss;
  const bool last = tolerance == kFollowed[1];
  options_.arc_sigma = std::max({arc_sigma, least_sigma_, last && thorough_ ? believed_sigma_ : 0});
  options_.pair_weight = pairs_count_ || last ? 1 : tolerance == kFollowed[0] ? kFollowedPairs : kMatchedPairs;
  options_.near_the_end = tolerance <= kFollowed[0];
  options_.settled = tolerance > kMatched[2] ? kRough : tolerance > kFollowed[1] ? kFiner : kFine;
  cost_ = adjust(r.bundle, options_, job_).cost;
  if (last && thorough_) {
    adjust_whole_tracks(r.bundle, options_, sweep_->pixels(kTrackLoss), job_);
    adjust_narrowly(r.bundle, options_, sweep_->pixels(1), job_);
  } else if (!last) {
    believed_sigma_ = options_.model == Model::free ? scatter_about_arc(r) / noise_px(r) : 0;
  }
}

// Deviation of a coordinate of an observation of weight 1, by what the adjustment left: its cost is half the sum over
// both coordinates of all.
double Rounds::noise_px(const Reconstruction& r) const {
  const double count = static_cast<double>(r.bundle.observations.size());
  return std::max(std::sqrt(cost_ / std::max(1.0, count)), sweep_->pixels(kLeastNoise));
}

void Rounds::decide_distortion(Reconstruction& r) {
  if (options_.refine_distortion) return;
  std::optional<Bundle> bent = bent_lens(r.bundle, options_, cost_, job_);
  if (!bent) return;
  r.bundle = std::move(*bent);
  options_.refine_distortion = true;
}

void Rounds::place(const std::vector<Track>& tracks, double tolerance, Reconstruction& r) const {
  r.tracks = place_good(tracks, sweep_->pixels(tolerance), options_.model == Model::rotation, r.bundle, job_);
}

// Where a frame has more than a few.
void Rounds::leave_out_loners(Reconstruction& r) const {
  const std::vector<bool> alone = loners(r.tracks, r.bundle, sweep_->pixels(kLoner));
  const std::vector<int> held = observations_by_frame(r);
  std::vector<Track> kept;
  Bundle bundle = r.bundle;
  bundle.points.clear();
  bundle.observations.clear();
  for (size_t i = 0; i < alone.size(); ++i) {
    const auto poor = [&](const Observation& o) { return held[static_cast<size_t>(o.frame)] < kHeld; };
    if (alone[i] && std::none_of(r.tracks[i].begin(), r.tracks[i].end(), poor)) continue;
    add_point(r.tracks[i], r.bundle.points[i], bundle);
    kept.push_back(std::move(r.tracks[i]));
  }
  r.tracks = std::move(kept);
  r.bundle = std::move(bundle);
}

}  // namespace ldp
