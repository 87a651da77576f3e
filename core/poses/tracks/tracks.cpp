#include "core/poses/tracks/tracks.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

// Track merging: union-find over all features of all frames; every set keeps its members so that conflicts are seen
// before joining.
class TrackMerger {
 public:
  explicit TrackMerger(const std::vector<Features>& features) : features_(features) {
    for (const Features& f : features) {
      first_.push_back(static_cast<int>(parent_.size()));
      for (int i = 0; i < f.size(); ++i) {
        members_.push_back({{static_cast<int>(first_.size()) - 1, i, f.centred(i)}});
        parent_.push_back(static_cast<int>(parent_.size()));
      }
    }
  }

  void merge(const Observation& a, const Observation& b) {
    int x = root(a), y = root(b);
    if (x == y || conflict(x, y)) return;
    if (members(x).size() < members(y).size()) std::swap(x, y);
    parent_[static_cast<size_t>(y)] = x;
    members(x).insert(members(x).end(), members(y).begin(), members(y).end());
    members(y).clear();
  }

  // TrackMerger that span at least two frames, one observation (the first detected, i.e. the strongest) per frame.
  std::vector<Track> tracks() const {
    std::vector<Track> result;
    for (std::vector<Observation> set : members_) {
      std::sort(set.begin(), set.end(), [](const Observation& p, const Observation& q) {
        return std::tie(p.frame, p.feature) < std::tie(q.frame, q.feature);
      });
      Track track;
      for (const Observation& o : set) {
        if (track.empty() || track.back().frame != o.frame) track.push_back(o);
      }
      if (track.size() >= 2) result.push_back(std::move(track));
    }
    return result;
  }

 private:
  std::vector<Observation>& members(int set) { return members_[static_cast<size_t>(set)]; }

  int root(const Observation& o) {
    int i = first_[static_cast<size_t>(o.frame)] + o.feature;
    while (parent_[static_cast<size_t>(i)] != i) {
      int& up = parent_[static_cast<size_t>(i)];
      up = parent_[static_cast<size_t>(up)];
      i = up;
    }
    return i;
  }

  const Eigen::Vector2d& position(const Observation& o) const {
    return features_[static_cast<size_t>(o.frame)].positions[static_cast<size_t>(o.feature)];
  }

  bool conflict(int x, int y) {
    for (const Observation& p : members(x)) {
      for (const Observation& q : members(y)) {
        if (p.frame == q.frame && (position(p) - position(q)).norm() > kSameFeature_px) return true;
      }
    }
    return false;
  }

  const std::vector<Features>& features_;
  std::vector<int> first_, parent_;
  std::vector<std::vector<Observation>> members_;
};

}  // namespace

std::vector<Track> build_tracks(const std::vector<Features>& features, const std::vector<PairMatches>& pairs) {
  struct Link {
    int distance = 0;
    Observation a, b;
  };
  std::vector<Link> links;
  for (const PairMatches& pair : pairs) {
    for (const Match& m : pair.matches)
      links.push_back({m.distance, {pair.a, m.a, Eigen::Vector2d::Zero()}, {pair.b, m.b, Eigen::Vector2d::Zero()}});
  }
  std::sort(links.begin(), links.end(), [](const Link& p, const Link& q) {
    return std::tie(p.distance, p.a.frame, p.b.frame, p.a.feature, p.b.feature) <
           std::tie(q.distance, q.a.frame, q.b.frame, q.a.feature, q.b.feature);
  });
  TrackMerger merger(features);
  for (const Link& link : links) merger.merge(link.a, link.b);
  return merger.tracks();
}

size_t grid_cell(const Eigen::Vector2d& from_middle_px, const Features& photo, int grid) {
  const auto cell = [&](double px, int size_px) {
    return static_cast<size_t>(std::clamp(static_cast<int>((px / size_px + 0.5) * grid), 0, grid - 1));
  };
  return cell(from_middle_px.y(), photo.height) * static_cast<size_t>(grid) + cell(from_middle_px.x(), photo.width);
}

std::vector<Track> longest_tracks(std::vector<Track> tracks, const std::vector<Features>& frames, int per_frame,
                                  int grid) {
  const size_t cells = static_cast<size_t>(grid * grid);
  const int share = (per_frame + grid * grid - 1) / (grid * grid);
  std::vector<int> taken(frames.size() * cells, 0);
  const auto taken_near = [&](const Observation& o) -> int& {
    const size_t frame = static_cast<size_t>(o.frame);
    return taken[frame * cells + grid_cell(o.position_px, frames[frame], grid)];
  };
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.size() > b.size(); });
  std::vector<Track> chosen;
  for (const Track& track : tracks) {
    if (std::all_of(track.begin(), track.end(), [&](const Observation& o) { return taken_near(o) >= share; })) continue;
    for (const Observation& o : track) ++taken_near(o);
    chosen.push_back(track);
  }
  return chosen;
}

}  // namespace ldp::sfm
