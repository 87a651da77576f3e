#include "core/poses/refine/smooth_motion.h"

#include <numeric>
#include <utility>

#include "core/poses/start/motion_model.h"
#include "core/poses/tracks/point_placement.h"

namespace ldp {
namespace {

constexpr double kSteady[] = {0.02, 0.01, 0.02};  // sigmas of the arc prior in rounds that ask for a steadier hand
constexpr double kSteadyHand = 1.0 / 3;           // share of what is explained that may be given for steadiness
constexpr double kTorn = 0.5;                     // of what others explain across a step: less is left where it tears
constexpr int kTelling = 30;                      // tracks across a step from which their loss tells something

std::vector<Track> agreeing(const MatchedSweep& sweep, const std::vector<Track>& tracks, Reconstruction r,
                            const Job& job) {
  return place_good(tracks, sweep.pixels(kMatched[2]), false, r.bundle, job);
}

// Cameras put back on their sphere and held near it while what agrees with them gathers. The lens keeps its bend:
// freed, it would take on what the sphere cannot explain, and half the focal length with a barrel's bend passes for
// any.
void steady(const MatchedSweep& sweep, const std::vector<Track>& tracks, Rounds rounds, Reconstruction& r) {
  rounds.stay_on_the_arc();
  rounds.keep_the_bend();
  for (Pose& pose : r.bundle.cameras) pose.centre = pose.world_from_camera.col(2);
  const std::vector<Track> thin = longest_tracks(tracks, sweep.frames(), kThin);
  for (size_t i = 0; i < std::size(kSteady); ++i)
    rounds.round(i + 1 < std::size(kSteady) ? thin : tracks, kMatched[i], kSteady[i], r);
}

// What walks by is some of what a step shows. A hand that is steadier for the loss of nearly all of it is at the wrong
// place there.
bool steadier_is_better(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Reconstruction& steadied,
                        const Reconstruction& other, const Job& job) {
  const std::vector<Track> held = agreeing(sweep, tracks, steadied, job),
                           of_other = agreeing(sweep, tracks, other, job);
  const double steadier =
      1 - unsteadiness(steadied.dropped, steadied.bundle) / unsteadiness(other.dropped, other.bundle);
  const double least = (1 - kSteadyHand * steadier) * static_cast<double>(observations(of_other));
  return static_cast<double>(observations(held)) >= least &&
         !tears(across_steps(held, sweep.frames()), across_steps(of_other, sweep.frames()));
}

}  // namespace

size_t observations(const std::vector<Track>& tracks) {
  return std::accumulate(tracks.begin(), tracks.end(), size_t{0},
                         [](size_t sum, const Track& t) { return sum + t.size(); });
}

double explained(const MatchedSweep& sweep, const std::vector<Track>& tracks, Reconstruction r, const Job& job) {
  return static_cast<double>(observations(agreeing(sweep, tracks, std::move(r), job)));
}

std::vector<int> across_steps(const std::vector<Track>& tracks, int frames) {
  std::vector<int> across(static_cast<size_t>(frames), 0);
  for (const Track& track : tracks) {
    for (size_t i = 0; i + 1 < track.size(); ++i) {
      if (track[i + 1].frame == track[i].frame + 1) ++across[static_cast<size_t>(track[i].frame)];
    }
  }
  return across;
}

bool tears(const std::vector<int>& across, const std::vector<int>& across_of_others) {
  for (size_t i = 0; i < across.size(); ++i) {
    if (across_of_others[i] >= kTelling && across[i] <= kTorn * across_of_others[i]) return true;
  }
  return false;
}

void last_matched_round(const MatchedSweep& sweep, const std::vector<Track>& tracks, Rounds& rounds, const Job& job,
                        Reconstruction& result) {
  const bool on_an_arc = rounds.on_an_arc();
  Reconstruction steadied = result;
  if (on_an_arc) rounds.use_threads(job.threads / 2);
  const Rounds before = rounds;
  parallel_for(job, on_an_arc ? 2 : 1, [&](int which) {
    if (which == 1) return steady(sweep, tracks, before, steadied);
    rounds.round(tracks, kMatched[2], kAboutArc, result);
    rounds.decide_distortion(result);
  });
  rounds.use_threads(job.threads);
  if (!on_an_arc) return;
  if (rounds.bent() && !before.bent()) steady(sweep, tracks, rounds, steadied = result);
  if (steadier_is_better(sweep, tracks, steadied, result, job)) result = std::move(steadied);
}

}  // namespace ldp
