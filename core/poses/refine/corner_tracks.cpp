#include "core/poses/refine/corner_tracks.h"

#include <algorithm>
#include <iterator>

#include "core/poses/features/corners.h"
#include "core/poses/refine/arc_conditioning.h"
#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/refine/occupancy_grid.h"
#include "core/poses/refine/refine_tuning.h"
#include "core/poses/tracks/epipolar_search.h"
#include "core/poses/tracks/klt_tracking.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

// Tracks of one observation, and the depths that the search found for them.
struct CornerCandidates {
  std::vector<Track> tracks;
  std::vector<InversePoint> points;
};

CornerCandidates candidates_of_frame(const MatchedSweep& sweep, const Reconstruction& r, const EpipolarSearch& search,
                                     size_t frame, int wanted) {
  CornerCandidates candidates;
  const GreyImage& grey = sweep.pictures[frame].grey;
  OccupancyGrid occupied(sweep.features[frame].width, sweep.features[frame].height, sweep.pixels(kMinCornerSpacing_px));
  for (const Track& track : r.tracks) {
    for (const Observation& o : track) {
      if (static_cast<size_t>(o.frame) == frame && track.size() >= kMinCornerViews) occupied.add(o.position_px);
    }
  }
  int left = static_cast<int>(kTriedPerWantedCorner * wanted);
  const int share = kMaxCornerCellShare * left / (kCornerGridCells * kCornerGridCells) + 1;
  std::vector<int> tried(size_t{kCornerGridCells} * kCornerGridCells, 0);
  for (const Corner& corner : find_corners(grey, kSearchMargin_px)) {
    if (left <= 0 || wanted <= 0) break;
    const Eigen::Vector2d p = search.from_picture({corner.x + 0.5, corner.y + 0.5}, frame);
    int& here = tried[static_cast<size_t>(corner.y * kCornerGridCells / grey.height * kCornerGridCells +
                                          corner.x * kCornerGridCells / grey.width)];
    if (here >= share || occupied.near(p)) continue;
    const EpipolarSearch::Found found = search.search(frame, p);
    if (!found.compared) continue;
    ++here, --left;
    occupied.add(p);
    if (!found.point) continue;
    --wanted;
    candidates.tracks.push_back({{static_cast<int>(frame), -1, p}});
    candidates.points.push_back(*found.point);
  }
  return candidates;
}

// One list of all frames, in their order.
CornerCandidates corner_candidates(const MatchedSweep& sweep, const Reconstruction& r, const Job& job) {
  const EpipolarSearch search(sweep, r.tracks, r.bundle);
  const std::vector<int> between = tracks_through_frame(r);
  std::vector<CornerCandidates> of_frames(between.size());
  parallel_for(job, static_cast<int>(between.size()), [&](int frame) {
    const size_t i = static_cast<size_t>(frame);
    if (search.sees_known_points(i) && between[i] < kWantedCorners)
      of_frames[i] = candidates_of_frame(sweep, r, search, i, kWantedCorners - between[i]);
  });
  CornerCandidates all;
  for (CornerCandidates& g : of_frames) {
    std::move(g.tracks.begin(), g.tracks.end(), std::back_inserter(all.tracks));
    all.points.insert(all.points.end(), g.points.begin(), g.points.end());
  }
  return all;
}

// Without those that show what is known, or what another does that more photos show.
std::vector<Track> without_duplicates(const MatchedSweep& sweep, const std::vector<Track>& known,
                                      std::vector<Track> tracks) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.size() > b.size(); });
  std::vector<OccupancyGrid> occupied;
  for (const Features& f : sweep.features) occupied.emplace_back(f.width, f.height, sweep.pixels(kDuplicateTrack_px));
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

void add_corner_tracks(const MatchedSweep& sweep, const Job& job, Reconstruction& r) {
  CornerCandidates candidates = corner_candidates(sweep, r, job);
  Bundle bundle{r.bundle.cameras, r.bundle.lens, std::move(candidates.points), {}};
  std::vector<Track> found = track_points(sweep.pictures, candidates.tracks, bundle, KltOptions{}, job);
  std::erase_if(found, [](const Track& t) { return t.size() < kMinCornerViews; });
  found = without_duplicates(sweep, r.tracks, std::move(found));
  found = triangulate_inliers(found, sweep.pixels(kKltTolerances_px[0]), false, bundle, job);
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i].size() < kMinCornerViews) continue;
    add_point(found[i], bundle.points[i], r.bundle);
    r.tracks.push_back(std::move(found[i]));
  }
}

}  // namespace ldp::sfm
