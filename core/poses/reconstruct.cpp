#include "core/poses/reconstruct.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "core/poses/refine/arc_conditioning.h"
#include "core/poses/refine/corner_tracks.h"
#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/refine/resection.h"
#include "core/poses/refine/smooth_motion.h"
#include "core/poses/start/incremental_start.h"
#include "core/poses/start/motion_model.h"
#include "core/poses/tracks/guided_matching.h"
#include "core/poses/tracks/klt_tracking.h"
#include "core/poses/tracks/point_placement.h"

namespace ldp {
namespace {

constexpr int kLeastPosed = 3;                   // frames
constexpr int kLeastInliers = 12;                // observations that hold a frame in place
constexpr double kOverrules = 1.1;               // by so much more must cameras off the circle explain
constexpr double kBetter = 1.2;                  // by so much more must other motion explain to be preferred
constexpr double kBetterArc = 1.05;              // the same where it turns out to be an arc after all
constexpr double kTornMatches = 0.05;            // of all matches, in pairs that do not hold
constexpr double kTorn = 0.3, kTornPixels = 12;  // share of a pair's matches that must agree within so many
                                                 // pixels of 800 for it to hold
constexpr double kEnough = 1 / kBetter;          // share of the observations that must fit, else other motion is tried
constexpr size_t kRich = 1000;                   // observations per frame that make a second look for matches needless
constexpr double kStillHolds = 0.9;  // share of the matches explained before that a round on followed points must keep
constexpr int kMostFollowed = 4;     // rounds on followed points at the wider tolerance, until the focal
constexpr double kSettledFocal = 5e-4;  // length changes by no more than this share

// Frames that hang together by pairs that count: the same number for all of a group.
std::vector<int> groups(const MatchedSweep& sweep, const std::function<bool(const PairMatches&)>& counts) {
  std::vector<int> group(static_cast<size_t>(sweep.frames()));
  std::iota(group.begin(), group.end(), 0);
  for (const PairMatches& pair : sweep.pairs) {
    if (!counts(pair)) continue;
    const int from = group[static_cast<size_t>(pair.b)], to = group[static_cast<size_t>(pair.a)];
    std::replace(group.begin(), group.end(), from, to);
  }
  return group;
}

const std::string kBare = "it shows next to no texture";

// All but the largest group that hangs together by matches are dropped with a reason.
std::vector<std::string> loose_frames(const MatchedSweep& sweep) {
  const std::vector<int> group = groups(sweep, [](const PairMatches&) { return true; });
  std::vector<int> partners(group.size(), 0);
  for (const PairMatches& pair : sweep.pairs) {
    ++partners[static_cast<size_t>(pair.a)], ++partners[static_cast<size_t>(pair.b)];
  }
  int best = 0, most = 0;
  for (const int g : group) {
    const int count = static_cast<int>(std::count(group.begin(), group.end(), g));
    if (count > most) most = count, best = g;
  }
  std::vector<std::string> dropped(group.size());
  for (size_t i = 0; i < group.size(); ++i) {
    if (group[i] == best) continue;
    dropped[i] = sweep.features[i].size() < kLeastInliers ? kBare
                 : partners[i] == 0                       ? "it matches no other photo"
                                                          : "it matches only photos that do not connect with the rest";
  }
  return dropped;
}

int posed(const std::vector<std::string>& dropped) {
  return static_cast<int>(std::count(dropped.begin(), dropped.end(), std::string()));
}

void require(const MatchedSweep& sweep, const std::vector<std::string>& dropped) {
  if (posed(dropped) >= kLeastPosed) return;
  const bool bare = 2 * std::count(dropped.begin(), dropped.end(), kBare) >= sweep.frames();
  throw Impossible("only " + std::to_string(posed(dropped)) + " of " + std::to_string(sweep.frames() + sweep.left_out) +
                   " photos connect with each other; at least 3 are needed: " +
                   (bare ? "most show next to no texture: take them in more light, of something with detail"
                         : "take them with more overlap (three quarters), sharp and free of noise") +
                   (sweep.left_out > 0 ? "; left out was " + sweep.first_left_out : ""));
}

// Tracks without the observations of dropped frames.
std::vector<Track> connected(const std::vector<Track>& tracks, const std::vector<std::string>& dropped) {
  std::vector<Track> result;
  for (Track track : tracks) {
    std::erase_if(track, [&](const Observation& o) { return !dropped[static_cast<size_t>(o.frame)].empty(); });
    if (track.size() >= 2) result.push_back(std::move(track));
  }
  return result;
}

// Frames that hardly anything holds are dropped, with what they see.
void drop_unheld(Reconstruction& r) {
  const std::vector<int> held = observations_by_frame(r);
  for (size_t i = 0; i < held.size(); ++i) {
    if (!r.dropped[i].empty() || held[i] >= kLeastInliers) continue;
    r.dropped[i] = "only " + std::to_string(held[i]) + " of its points agree with the other photos";
  }
  r.tracks = connected(r.tracks, r.dropped);
}

// The reconstruction's tracks followed through all frames. Those that cannot be followed stay as matched where a frame
// has little else.
std::vector<Track> follow(const MatchedSweep& sweep, const Reconstruction& r, const Job& job) {
  std::vector<Track> tracks = follow_points(sweep.pictures, r.tracks, r.bundle, FollowOptions{}, job);
  std::vector<int> held(r.dropped.size(), 0);
  for (const Track& track : tracks) {
    for (const Observation& o : track) held[static_cast<size_t>(o.frame)] += track.size() > 1 ? 1 : 0;
  }
  for (size_t i = 0; i < tracks.size(); ++i) {
    const auto poor = [&](const Observation& o) { return held[static_cast<size_t>(o.frame)] < kHeld; };
    if (tracks[i].size() < 2 && std::any_of(r.tracks[i].begin(), r.tracks[i].end(), poor)) tracks[i] = r.tracks[i];
  }
  return tracks;
}

// A round on followed points. Where steps are so wide that hardly a third photo sees any, the cameras go astray if
// those of two photos weigh little: what was matched tells so, and the round is done again with all points equal.
// Takes and gives how much of that is explained.
double followed_round(const MatchedSweep& sweep, const std::vector<Track>& matched, double tolerance,
                      double explained_before, Rounds& rounds, const Job& job, Reconstruction& r) {
  const Reconstruction before = r;
  rounds.round(follow(sweep, r, job), tolerance, kAboutArc, r);
  const double explained_now = explained(sweep, matched, r, job);
  if (explained_now >= kStillHolds * explained_before) return explained_now;
  rounds.let_pairs_count();
  r = before;
  rounds.round(follow(sweep, r, job), tolerance, kAboutArc, r);
  return explained(sweep, matched, r, job);
}

// The same until the focal length settles: points that a wrong one gathered leave a few at a time.
void settle(const MatchedSweep& sweep, const std::vector<Track>& matched, Rounds& rounds, const Job& job,
            Reconstruction& r) {
  double holds = explained(sweep, matched, r, job);
  for (int i = 0; i < kMostFollowed; ++i) {
    const double before = r.bundle.lens.focal_px;
    holds = followed_round(sweep, matched, kFollowed[0], holds, rounds, job, r);
    if (std::abs(std::log(r.bundle.lens.focal_px / before)) < kSettledFocal) return;
  }
}

// Cameras near their circle, unless the data overrule it.
void first_round(const MatchedSweep& sweep, const std::vector<Track>& tracks, Rounds& rounds, const Job& job,
                 Reconstruction& result) {
  const std::vector<Track> thin = longest_tracks(tracks, sweep.frames(), kThin);
  Reconstruction off = result;
  rounds.use_threads(job.threads / 2);
  Rounds off_rounds = rounds;
  parallel_for(job, 2, [&](int which) {
    which == 0 ? rounds.round(thin, kMatched[0], kNearArc, result) : off_rounds.round(thin, kMatched[0], kFarArc, off);
  });
  rounds.use_threads(job.threads);
  if (explained(sweep, tracks, off, job) < kOverrules * explained(sweep, tracks, result, job)) return;
  result = std::move(off);
  rounds.leave_the_arc();
}

// Whether the sweep fell apart: photos hang together by matches, but no longer by those that agree with the cameras; or
// too many matches are of photos that do not agree.
bool torn(const MatchedSweep& sweep, const Reconstruction& r) {
  double all = 0, against = 0;
  const std::vector<int> group = groups(sweep, [&](const PairMatches& pair) {
    const auto posed = [&](int frame) { return r.dropped[static_cast<size_t>(frame)].empty(); };
    if (!posed(pair.a) || !posed(pair.b)) return false;
    const double matches = static_cast<double>(pair.matches.size());
    const bool holds = agreeing_share(sweep, r.bundle, pair, sweep.pixels(kTornPixels)) >= kTorn;
    all += matches;
    if (!holds) against += matches;
    return holds;
  });
  if (against > kTornMatches * all) return true;
  int first = -1;
  for (size_t i = 0; i < group.size(); ++i) {
    if (!r.dropped[i].empty()) continue;
    if (first < 0) first = group[i];
    if (group[i] != first) return true;
  }
  return false;
}

// Where the sweep fell apart, the cameras may have turned by more than they seemed to: where all is far a step to the
// side shows like a turn, and a circle that lacks a few degrees tears where it should close. The same is tried from the
// turns of cameras that stay where they are.
void try_turns_on_the_spot(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& on_the_spot,
                           Rounds& rounds, const Job& job, Reconstruction& result) {
  if (!torn(sweep, result)) return;
  Reconstruction other = result;
  other.bundle = on_the_spot;
  Rounds other_rounds = rounds;
  other_rounds.stay_on_the_arc();
  first_round(sweep, tracks, other_rounds, job, other);
  if (explained(sweep, tracks, other, job) < kBetterArc * explained(sweep, tracks, result, job)) return;
  rounds = other_rounds;
  result = std::move(other);
}

bool a_cameras(const MatchedSweep& sweep, double focal_px) {
  const double view = view_of_longer_side(sweep, focal_px);
  return view > kTooNarrow && view < kTooWide;
}

// Where spherical motion leaves too much unexplained, or asks for a lens that no camera has, general motion gets its
// chance; the one that explains more stays.
void try_general_motion(const MatchedSweep& sweep, const std::vector<Track>& tracks,
                        const std::optional<FocalPrior>& focal, Rounds& rounds, const Job& job,
                        Reconstruction& result) {
  Reconstruction spherical = result;
  spherical.tracks = place_good(tracks, sweep.pixels(kMatched[2]), false, spherical.bundle, job);
  const auto count = [](const Reconstruction& r) { return static_cast<double>(observations(r.tracks)); };
  const bool poor = count(spherical) <= kEnough * static_cast<double>(observations(tracks));
  const bool lens = focal || a_cameras(sweep, result.bundle.lens.focal_px);
  if (!poor && lens && !torn(sweep, result)) return;
  std::optional<GeneralStart> start = general_start(sweep, tracks, focal, result.bundle.lens.focal_px, job);
  if (!start) return;
  Reconstruction general = result;
  general.bundle = std::move(start->bundle);
  for (size_t i = 0; i < start->posed.size(); ++i) {
    if (!start->posed[i] && general.dropped[i].empty())
      general.dropped[i] = "it shares too few points with the other photos";
  }
  const bool arc = move_to_sphere(general.dropped, general.bundle);
  general.tracks =
      place_good(connected(tracks, general.dropped), sweep.pixels(kMatched[2]), false, general.bundle, job);
  const bool better_lens = !lens && a_cameras(sweep, general.bundle.lens.focal_px);
  if (count(general) < (better_lens ? 1 : arc ? kBetterArc : kBetter) * count(spherical)) return;
  arc ? rounds.leave_the_arc() : rounds.forget_the_arc();
  result = std::move(general);
}

}  // namespace

Reconstruction reconstruct(MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job) {
  Reconstruction result;
  const std::vector<Turns> turns = ldp::turns(sweep, focal, Turning::on_the_sphere, job);
  sweep.pairs = without_contradictions(std::move(sweep.pairs), turns);
  result.dropped = loose_frames(sweep);
  require(sweep, result.dropped);
  std::vector<Track> tracks = build_tracks(sweep.features, sweep.pairs);
  tracks = connected(tracks, result.dropped);
  Rounds rounds(sweep, focal, job);
  const auto thin = [&] { return longest_tracks(tracks, sweep.frames(), kThin); };
  result.bundle = start_on_the_spot(sweep, tracks, ldp::turns(sweep, focal, Turning::on_the_spot, job), focal, job);
  job.report("adjusting", 0.7);
  if (!only_turns(sweep, tracks, result.bundle, job)) {
    const Bundle on_the_spot = std::exchange(result.bundle, start(sweep, tracks, turns, focal, job));
    first_round(sweep, tracks, rounds, job, result);
    try_turns_on_the_spot(sweep, tracks, on_the_spot, rounds, job, result);
    try_general_motion(sweep, tracks, focal, rounds, job, result);
    if (only_turns(sweep, result.tracks, result.bundle, job)) result.motion = Motion::rotation;
  } else {
    result.motion = Motion::rotation;
  }
  if (result.motion == Motion::rotation) rounds.set_model(Model::rotation);
  tracks = connected(tracks, result.dropped);
  rounds.round(thin(), kMatched[1], kAboutArc, result);
  if (rounds.on_an_arc() && reseat_lost_frames(sweep, result)) {
    rounds.round(thin(), kMatched[0], kNearArc, result);
    rounds.round(thin(), kMatched[1], kAboutArc, result);
  }
  if (result.motion != Motion::rotation && observations(tracks) < kRich * static_cast<size_t>(posed(result.dropped))) {
    const std::vector<PairMatches> pairs = match_guided(sweep, result.bundle, result.dropped, job);
    tracks = connected(build_tracks(sweep.features, pairs), result.dropped);
    rounds.round(thin(), kMatched[1], kAboutArc, result);
  }
  last_matched_round(sweep, tracks, rounds, job, result);
  job.report("adjusting", 0.8);
  settle(sweep, tracks, rounds, job, result);
  rounds.decide_distortion(result);  // before corners join: it compares costs of the same points
  if (result.motion != Motion::rotation) describe_motion(sweep, result);
  if (loosely_held(result)) {
    gather_corners(sweep, job, result);
    rounds.end_thoroughly();
  }
  job.report("adjusting", 0.9);
  followed_round(sweep, tracks, kFollowed[1], explained(sweep, tracks, result, job), rounds, job, result);
  drop_unheld(result);
  require(sweep, result.dropped);
  rounds.place(result.tracks, kFollowed[1], result);
  if (result.motion != Motion::rotation) describe_motion(sweep, result);
  return result;
}

}  // namespace ldp
