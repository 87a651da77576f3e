#include "core/poses/tracks/track_triangulation.h"

#include <algorithm>
#include <optional>

#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

bool mostly_outliers(const std::vector<bool>& used) {
  const size_t agreeing = static_cast<size_t>(std::count(used.begin(), used.end(), true));
  return used.size() > 2 && 2 * agreeing <= used.size();
}

}  // namespace

void triangulate_tracks(const std::vector<Track>& tracks, Bundle& bundle) {
  bundle.points.clear();
  bundle.observations.clear();
  for (const Track& track : tracks) {
    const std::vector<Sighting> s = sightings(track, bundle);
    std::optional<InversePoint> point = triangulate_point(s);
    if (!point || !is_plausible(*point)) {
      const Sighting& middle = s[s.size() / 2];
      const Eigen::Vector3d ray = middle.camera_from_world.transpose() * middle.position.homogeneous().normalized();
      point = InversePoint{(ray + kDefaultInverseDistance * middle.centre).normalized(), kDefaultInverseDistance};
    }
    add_point(track, *point, bundle);
  }
}

std::vector<Track> triangulate_inliers(const std::vector<Track>& tracks, double tolerance_px, bool at_infinity,
                                       Bundle& bundle, const Job& job) {
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
    if (!placed[i].point || !is_plausible(*placed[i].point) || mostly_outliers(placed[i].used)) continue;
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

}  // namespace ldp::sfm
