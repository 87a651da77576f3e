#include "core/poses/reconstruct.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "core/poses/poses_tuning.h"
#include "core/poses/refine/arc_conditioning.h"
#include "core/poses/refine/corner_tracks.h"
#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/refine/resection.h"
#include "core/poses/refine/smooth_motion.h"
#include "core/poses/start/incremental_reconstruction.h"
#include "core/poses/start/motion_model.h"
#include "core/poses/tracks/guided_matching.h"
#include "core/poses/tracks/klt_tracking.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

// Frames that hang together by pairs that count: the same number for all of a group.
std::vector<int> connected_components(const MatchedSweep& sweep,
                                      const std::function<bool(const PairMatches&)>& counts) {
  std::vector<int> group(static_cast<size_t>(sweep.frames()));
  std::iota(group.begin(), group.end(), 0);
  for (const PairMatches& pair : sweep.pairs) {
    if (!counts(pair)) continue;
    const int from = group[static_cast<size_t>(pair.b)], to = group[static_cast<size_t>(pair.a)];
    std::replace(group.begin(), group.end(), from, to);
  }
  return group;
}

// All but the largest group that hangs together by matches are left out with a reason.
std::vector<LeftOut> unconnected_frames(const MatchedSweep& sweep) {
  const std::vector<int> group = connected_components(sweep, [](const PairMatches&) { return true; });
  std::vector<int> partners(group.size(), 0);
  for (const PairMatches& pair : sweep.pairs) {
    ++partners[static_cast<size_t>(pair.a)], ++partners[static_cast<size_t>(pair.b)];
  }
  int best = 0, most = 0;
  for (const int g : group) {
    const int count = static_cast<int>(std::count(group.begin(), group.end(), g));
    if (count > most) most = count, best = g;
  }
  std::vector<LeftOut> left_out(group.size());
  for (size_t i = 0; i < group.size(); ++i) {
    if (group[i] == best) continue;
    left_out[i].cause = sweep.features[i].size() < kMinFrameObservations ? LeftOutCause::without_texture
                        : partners[i] == 0                               ? LeftOutCause::unmatched
                                                                         : LeftOutCause::matched_elsewhere;
  }
  return left_out;
}

int posed(const std::vector<LeftOut>& left_out) {
  return static_cast<int>(std::count_if(left_out.begin(), left_out.end(), [](const LeftOut& why) { return !why; }));
}

void require(const MatchedSweep& sweep, const std::vector<LeftOut>& left_out) {
  if (posed(left_out) >= kMinPosedFrames) return;
  const auto bare = std::count_if(left_out.begin(), left_out.end(),
                                  [](const LeftOut& why) { return why.cause == LeftOutCause::without_texture; });
  throw Impossible(
      "only " + std::to_string(posed(left_out)) + " of " + std::to_string(sweep.frames() + sweep.unfit) +
      " photos connect with each other; at least 3 are needed: " +
      (2 * bare >= sweep.frames() ? "most show next to no texture: take them in more light, of something with detail"
                                  : "take them with more overlap (three quarters), sharp and free of noise") +
      (sweep.first_unfit ? "; left out was " + sweep.first_unfit_name + ": " + words_of(sweep.first_unfit) : ""));
}

// Tracks without the observations of frames left out.
std::vector<Track> without_left_out(const std::vector<Track>& tracks, const std::vector<LeftOut>& left_out) {
  std::vector<Track> result;
  for (Track track : tracks) {
    std::erase_if(track,
                  [&](const Observation& o) { return static_cast<bool>(left_out[static_cast<size_t>(o.frame)]); });
    if (track.size() >= 2) result.push_back(std::move(track));
  }
  return result;
}

// Frames that hardly anything holds are left out, with what they see.
void drop_poorly_observed(Reconstruction& r) {
  const std::vector<int> held = observations_by_frame(r);
  for (size_t i = 0; i < held.size(); ++i) {
    if (r.left_out[i] || held[i] >= kMinFrameObservations) continue;
    r.left_out[i].cause = LeftOutCause::few_inliers;
    r.left_out[i].inliers = held[i];
  }
  r.tracks = without_left_out(r.tracks, r.left_out);
}

// Whether the sweep fell apart: photos hang together by matches, but no longer by those that agree with the cameras; or
// too many matches are of photos that do not agree.
bool is_disconnected(const MatchedSweep& sweep, const Reconstruction& r) {
  double all = 0, against = 0;
  const std::vector<int> group = connected_components(sweep, [&](const PairMatches& pair) {
    const auto posed = [&](int frame) { return !r.left_out[static_cast<size_t>(frame)]; };
    if (!posed(pair.a) || !posed(pair.b)) return false;
    const double matches = static_cast<double>(pair.matches.size());
    const bool holds =
        inlier_ratio(sweep, r.bundle, pair, sweep.pixels(kConnectedTolerance_px)) >= kMinConnectedInlierRatio;
    all += matches;
    if (!holds) against += matches;
    return holds;
  });
  if (against > kMaxOutlierPairShare * all) return true;
  int first = -1;
  for (size_t i = 0; i < group.size(); ++i) {
    if (r.left_out[i]) continue;
    if (first < 0) first = group[i];
    if (group[i] != first) return true;
  }
  return false;
}

bool is_plausible_focal(const MatchedSweep& sweep, double focal_px) {
  const double view = view_of_longer_side(sweep, focal_px);
  return view > kMinView_rad && view < kMaxView_rad;
}

// One reconstruction from matches to cameras. In order: outlier rejection among pairs, initialisation, refinement on
// matches, refinement on tracks by KLT.
class SweepReconstruction {
 public:
  SweepReconstruction(MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job)
      : sweep_(sweep), focal_(focal), job_(job), refinement_(sweep, focal, job) {}

  Reconstruction run() {
    initialise();
    refine_on_matches();
    refine_on_klt_tracks();
    return std::move(result_);
  }

 private:
  bool is_rotation() const { return result_.motion == Motion::rotation; }
  std::vector<Track> longest() const { return longest_tracks(tracks_, sweep_, kCoarseObservationsPerFrame); }
  double inliers(const Reconstruction& r) const { return inlier_observations(sweep_, tracks_, r, job_); }

  void initialise();
  void start_on_sphere(const std::vector<RotationHypothesis>& hypotheses);
  void coarse_refinement(IterativeRefinement& refinement, Reconstruction& result) const;
  void try_rotation_start(const Bundle& rotation);
  void try_incremental_reconstruction();
  Reconstruction registered_incrementally(IncrementalResult start, bool& is_arc) const;

  void refine_on_matches();
  void match_again_if_poor();

  void refine_on_klt_tracks();
  void become_rotation();
  std::vector<Track> klt_tracks() const;
  double klt_iteration(double tolerance, double inliers_before);
  void refine_until_focal_converges();

  MatchedSweep& sweep_;
  const std::optional<FocalPrior>& focal_;
  const Job& job_;
  std::vector<Track> tracks_;  // of matches
  IterativeRefinement refinement_;
  Reconstruction result_;
};

void SweepReconstruction::initialise() {
  const std::vector<RotationHypothesis> hypotheses =
      rotation_hypotheses(sweep_, focal_, TwoViewMotion::spherical, job_);
  sweep_.pairs = reject_inconsistent_matches(std::move(sweep_.pairs), hypotheses);
  result_.left_out = unconnected_frames(sweep_);
  require(sweep_, result_.left_out);
  tracks_ = without_left_out(build_tracks(sweep_.features, sweep_.pairs), result_.left_out);
  result_.bundle = initialise_pure_rotation(
      sweep_, tracks_, rotation_hypotheses(sweep_, focal_, TwoViewMotion::rotation, job_), focal_, job_);
  job_.report("adjusting", 0.7);
  if (is_pure_rotation(sweep_, tracks_, result_.bundle, job_)) {
    result_.motion = Motion::rotation;
  } else {
    start_on_sphere(hypotheses);
  }
  if (is_rotation()) refinement_.set_model(MotionModel::rotation);
  tracks_ = without_left_out(tracks_, result_.left_out);
}

void SweepReconstruction::start_on_sphere(const std::vector<RotationHypothesis>& hypotheses) {
  const Bundle rotation =
      std::exchange(result_.bundle, initialise_spherical(sweep_, tracks_, hypotheses, focal_, job_));
  coarse_refinement(refinement_, result_);
  try_rotation_start(rotation);
  try_incremental_reconstruction();
  if (is_pure_rotation(sweep_, result_.tracks, result_.bundle, job_)) result_.motion = Motion::rotation;
}

// Cameras near their circle, unless the data overrule it.
void SweepReconstruction::coarse_refinement(IterativeRefinement& refinement, Reconstruction& result) const {
  const std::vector<Track> coarse = longest();
  Reconstruction wide = result;
  refinement.use_threads(job_.threads / 2);
  IterativeRefinement wide_refinement = refinement;
  parallel_for(job_, 2, [&](int which) {
    which == 0 ? refinement.iterate(coarse, kCoarseTolerance_px, kTightArcSigma, result)
               : wide_refinement.iterate(coarse, kCoarseTolerance_px, kWideArcSigma, wide);
  });
  refinement.use_threads(job_.threads);
  if (inliers(wide) < kWideArcGain * inliers(result)) return;
  result = std::move(wide);
  refinement.set_min_arc_sigma(kWideArcSigma);
}

// Where the sweep fell apart, the cameras may have turned by more than they seemed to: where all is far a step to the
// side shows like a rotation, and a circle that lacks a few degrees breaks where a loop closure should hold it. The
// same is tried from cameras that rotate in one place.
void SweepReconstruction::try_rotation_start(const Bundle& rotation) {
  if (!is_disconnected(sweep_, result_)) return;
  Reconstruction other = result_;
  other.bundle = rotation;
  IterativeRefinement other_refinement = refinement_;
  other_refinement.set_min_arc_sigma(0);
  coarse_refinement(other_refinement, other);
  if (inliers(other) < kRestartGain * inliers(result_)) return;
  refinement_ = other_refinement;
  result_ = std::move(other);
}

// Where spherical motion leaves too much unexplained, or asks for a lens that no camera has, general motion gets its
// chance; the one that explains more stays.
void SweepReconstruction::try_incremental_reconstruction() {
  const double focal_px = result_.bundle.lens.focal_px;
  const double spherical = inliers(result_);
  const bool poor = spherical <= kMinExplainedShare * static_cast<double>(observations(tracks_));
  const bool plausible = focal_ || is_plausible_focal(sweep_, focal_px);
  if (!poor && plausible && !is_disconnected(sweep_, result_)) return;
  std::optional<IncrementalResult> start = reconstruct_incrementally(sweep_, tracks_, focal_, focal_px, job_);
  if (!start) return;
  bool is_arc = false;
  Reconstruction general = registered_incrementally(std::move(*start), is_arc);
  const bool better_focal = !plausible && is_plausible_focal(sweep_, general.bundle.lens.focal_px);
  const double gain = better_focal ? 1 : is_arc ? kRestartGain : kIncrementalGain;
  if (static_cast<double>(observations(general.tracks)) < gain * spherical) return;
  refinement_.set_min_arc_sigma(is_arc ? kWideArcSigma : kNoArcSigma);
  result_ = std::move(general);
}

Reconstruction SweepReconstruction::registered_incrementally(IncrementalResult start, bool& is_arc) const {
  Reconstruction general = result_;
  general.bundle = std::move(start.bundle);
  for (size_t i = 0; i < start.posed.size(); ++i) {
    if (!start.posed[i] && !general.left_out[i]) general.left_out[i].cause = LeftOutCause::few_shared_points;
  }
  is_arc = normalise_to_sphere(general.left_out, general.bundle);
  general.tracks = triangulate_inliers(without_left_out(tracks_, general.left_out), sweep_.pixels(kFineTolerance_px),
                                       false, general.bundle, job_);
  return general;
}

void SweepReconstruction::refine_on_matches() {
  refinement_.iterate(longest(), kMediumTolerance_px, kArcSigma, result_);
  if (refinement_.has_arc_prior() && resect_lost_frames(sweep_, result_)) {
    refinement_.iterate(longest(), kCoarseTolerance_px, kTightArcSigma, result_);
    refinement_.iterate(longest(), kMediumTolerance_px, kArcSigma, result_);
  }
  match_again_if_poor();
  final_match_refinement(sweep_, tracks_, refinement_, job_, result_);
}

void SweepReconstruction::match_again_if_poor() {
  const size_t rich = kRichObservationsPerFrame * static_cast<size_t>(posed(result_.left_out));
  if (is_rotation() || observations(tracks_) >= rich) return;
  const std::vector<PairMatches> pairs = match_guided(sweep_, result_.bundle, result_.left_out, job_);
  tracks_ = without_left_out(build_tracks(sweep_.features, pairs), result_.left_out);
  refinement_.iterate(longest(), kMediumTolerance_px, kArcSigma, result_);
}

void SweepReconstruction::refine_on_klt_tracks() {
  job_.report("adjusting", 0.8);
  if (!is_rotation() && share_beyond_infinity(result_.bundle) > kMaxBeyondShare) refinement_.enforce_cheirality();
  if (focal_ && focal_->is_guess) refinement_.forget_focal_prior();
  refine_until_focal_converges();
  // Before corners join: it compares costs of the same points.
  if (refinement_.select_distortion_model(result_)) refine_until_focal_converges();
  if (!is_rotation() && is_false_arc(sweep_, result_.tracks, result_.bundle, job_)) become_rotation();
  if (!is_rotation()) classify_motion(sweep_, result_);
  if (is_ill_conditioned(result_)) {
    add_corner_tracks(sweep_, job_, result_);
    refinement_.reweight_tracks_at_end();
  }
  job_.report("adjusting", 0.9);
  klt_iteration(kKltTolerances_px[1], inliers(result_));
  drop_poorly_observed(result_);
  require(sweep_, result_.left_out);
  refinement_.triangulate(result_.tracks, kKltTolerances_px[1], result_);
  if (!is_rotation()) classify_motion(sweep_, result_);
}

// The distortion that the arc took is chosen anew, too.
void SweepReconstruction::become_rotation() {
  result_.motion = Motion::rotation;
  refinement_.set_model(MotionModel::rotation);
  refinement_.fix_distortion();
  result_.bundle.lens.k1 = result_.bundle.lens.k2 = 0;
  refine_until_focal_converges();
  refinement_.select_distortion_model(result_);
}

// The reconstruction's tracks, tracked through all frames. Those that cannot be tracked stay as matched where a frame
// has little else.
std::vector<Track> SweepReconstruction::klt_tracks() const {
  const Reconstruction& r = result_;
  std::vector<Track> tracks = track_points(sweep_.pictures, r.tracks, r.bundle, KltOptions{}, job_);
  std::vector<int> observed(r.left_out.size(), 0);
  for (const Track& track : tracks) {
    for (const Observation& o : track) observed[static_cast<size_t>(o.frame)] += track.size() > 1 ? 1 : 0;
  }
  for (size_t i = 0; i < tracks.size(); ++i) {
    const auto poor = [&](const Observation& o) { return observed[static_cast<size_t>(o.frame)] < kWellObserved; };
    if (tracks[i].size() < 2 && std::any_of(r.tracks[i].begin(), r.tracks[i].end(), poor)) tracks[i] = r.tracks[i];
  }
  return tracks;
}

// One iteration on tracks by KLT. Where steps are so wide that hardly a third photo sees any, the cameras go astray if
// points of two photos weigh little: what was matched tells so, and the iteration is done again with all points equal.
// One that ruins the cameras even so is not kept. Takes and gives how many observations of matches are inliers.
double SweepReconstruction::klt_iteration(double tolerance, double inliers_before) {
  const Reconstruction before = result_;
  refinement_.iterate(klt_tracks(), tolerance, kArcSigma, result_);
  const double inliers_now = inliers(result_);
  if (inliers_now >= kMinKeptShare * inliers_before) return inliers_now;
  refinement_.trust_two_view_points();
  result_ = before;
  refinement_.iterate(klt_tracks(), tolerance, kArcSigma, result_);
  const double inliers_again = inliers(result_);
  if (inliers_again >= kRuinedShare * inliers_before) return inliers_again;
  result_ = before;
  return inliers_before;
}

// Points that a wrong focal length gathered leave a few at a time.
void SweepReconstruction::refine_until_focal_converges() {
  double count = inliers(result_);
  for (int i = 0; i < kMaxKltIterations; ++i) {
    const double before = result_.bundle.lens.focal_px;
    count = klt_iteration(kKltTolerances_px[0], count);
    if (std::abs(std::log(result_.bundle.lens.focal_px / before)) < kFocalConverged) return;
  }
}

}  // namespace

Reconstruction reconstruct(MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job) {
  return SweepReconstruction(sweep, focal, job).run();
}

}  // namespace ldp::sfm
