#include "core/poses/refine/corner_tracks.h"

#include <algorithm>
#include <iterator>

#include "core/poses/features/corners.h"
#include "core/poses/features/occupancy_grid.h"
#include "core/poses/refine/arc_conditioning.h"
#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/tracks/epipolar_search.h"
#include "core/poses/tracks/klt_tracking.h"
#include "core/poses/tracks/point_placement.h"

namespace ldp {
namespace {

constexpr int kWanted = 3000;     // things that a frame sees between two others that see them too: hardly ever so many
constexpr double kTried = 3;      // corners for each that is wanted
constexpr int kCells = 8;         // each way, over which what is tried spreads:
constexpr int kShare = 2;         // a cell has no more than so many times its even share
constexpr double kApart = 4;      // pixels of 800 between a corner and whatever else three see in its frame
constexpr double kSameThing = 3;  // pixels of 800: two tracks that come as near in a frame show one thing
constexpr size_t kLeast = 3;      // photos that must show a corner

// Tracks of one observation, and where their points are believed to be.
struct Guesses {
  std::vector<Track> tracks;
  std::vector<InversePoint> points;
};

Guesses guess(const MatchedSweep& sweep, const Reconstruction& r, const AlongSight& along, size_t frame, int wanted) {
  Guesses guesses;
  const GreyImage& grey = sweep.pictures[frame].grey;
  Occupied occupied(sweep.features[frame].width, sweep.features[frame].height, sweep.pixels(kApart));
  for (const Track& track : r.tracks) {
    for (const Observation& o : track) {
      if (static_cast<size_t>(o.frame) == frame && track.size() >= kLeast) occupied.add(o.position_px);
    }
  }
  int left = static_cast<int>(kTried * wanted);
  const int share = kShare * left / (kCells * kCells) + 1;
  std::vector<int> tried(kCells * kCells, 0);
  for (const Corner& corner : find_corners(grey, kSightMargin)) {
    if (left <= 0 || wanted <= 0) break;
    const Eigen::Vector2d p = along.from_picture({corner.x + 0.5, corner.y + 0.5}, frame);
    int& here = tried[static_cast<size_t>(corner.y * kCells / grey.height * kCells + corner.x * kCells / grey.width)];
    if (here >= share || occupied.near(p)) continue;
    const AlongSight::Found found = along.find(frame, p);
    if (!found.compared) continue;
    ++here, --left;
    occupied.add(p);
    if (!found.point) continue;
    --wanted;
    guesses.tracks.push_back({{static_cast<int>(frame), -1, p}});
    guesses.points.push_back(*found.point);
  }
  return guesses;
}

// One list of all frames, in their order.
Guesses guesses(const MatchedSweep& sweep, const Reconstruction& r, const Job& job) {
  const AlongSight along(sweep, r.tracks, r.bundle);
  const std::vector<int> between = seen_between(r);
  std::vector<Guesses> of_frames(between.size());
  parallel_for(job, static_cast<int>(between.size()), [&](int frame) {
    const size_t i = static_cast<size_t>(frame);
    if (along.knows(i) && between[i] < kWanted) of_frames[i] = guess(sweep, r, along, i, kWanted - between[i]);
  });
  Guesses all;
  for (Guesses& g : of_frames) {
    std::move(g.tracks.begin(), g.tracks.end(), std::back_inserter(all.tracks));
    all.points.insert(all.points.end(), g.points.begin(), g.points.end());
  }
  return all;
}

// Without those that show what is known, or what another does that more photos show.
std::vector<Track> new_tracks(const MatchedSweep& sweep, const std::vector<Track>& known, std::vector<Track> tracks) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.size() > b.size(); });
  std::vector<Occupied> occupied;
  for (const Features& f : sweep.features) occupied.emplace_back(f.width, f.height, sweep.pixels(kSameThing));
  const auto add = [&](const Track& track) {
    for (const Observation& o : track) occupied[static_cast<size_t>(o.frame)].add(o.position_px);
  };
  for (const Track& track : known) add(track);
  std::vector<Track> kept;
  for (Track& track : tracks) {
    const auto taken = [&](const Observation& o) { return occupied[static_cast<size_t>(o.frame)].near(o.position_px); };
    if (std::any_of(track.begin(), track.end(), taken)) continue;
    add(track);
    kept.push_back(std::move(track));
  }
  return kept;
}

}  // namespace

void gather_corners(const MatchedSweep& sweep, const Job& job, Reconstruction& r) {
  Guesses guessed = guesses(sweep, r, job);
  Bundle bundle{r.bundle.cameras, r.bundle.lens, std::move(guessed.points), {}};
  std::vector<Track> found = follow_points(sweep.pictures, guessed.tracks, bundle, FollowOptions{}, job);
  std::erase_if(found, [](const Track& t) { return t.size() < kLeast; });
  found = new_tracks(sweep, r.tracks, std::move(found));
  found = place_good(found, sweep.pixels(kFollowed[0]), false, bundle, job);
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i].size() < kLeast) continue;
    add_point(found[i], bundle.points[i], r.bundle);
    r.tracks.push_back(std::move(found[i]));
  }
}

}  // namespace ldp
