#include "unmatched.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ldp {
namespace {

constexpr double kApart = 6;      // pixels of 800 between a guess and whatever else is followed in its frame
constexpr double kSameThing = 3;  // pixels of 800: two tracks that come as near in a frame show one thing
constexpr double kNear = 80;      // pixels of 800 to what tells how far a guess may be
constexpr double kTried = 2;      // guesses for each that is wanted

// What is at which place of a frame, by cells as large as the distance that is asked for.
class Occupied {
 public:
  Occupied(const Features& frame, double apart)
      : apart_(apart),
        width_(frame.width),
        height_(frame.height),
        columns_(static_cast<int>(frame.width / apart) + 3),
        cells_(static_cast<size_t>(columns_) * static_cast<size_t>(static_cast<int>(frame.height / apart) + 3)) {}

  bool near(const Eigen::Vector2d& p) const {
    const size_t at = cell(p);
    for (const size_t row : {at - static_cast<size_t>(columns_), at, at + static_cast<size_t>(columns_)}) {
      for (size_t i = row - 1; i <= row + 1; ++i) {
        for (const Eigen::Vector2d& q : cells_[i]) {
          if ((p - q).squaredNorm() < apart_ * apart_) return true;
        }
      }
    }
    return false;
  }
  void add(const Eigen::Vector2d& p) { cells_[cell(p)].push_back(p); }

 private:
  size_t cell(const Eigen::Vector2d& p) const {
    const double x = std::clamp(p.x() + 0.5 * width_, 0.0, width_), y = std::clamp(p.y() + 0.5 * height_, 0.0, height_);
    return static_cast<size_t>((static_cast<int>(y / apart_) + 1) * columns_ + static_cast<int>(x / apart_) + 1);
  }

  double apart_, width_, height_;
  int columns_;
  std::vector<std::vector<Eigen::Vector2d>> cells_;
};

struct Known {
  Eigen::Vector2d position_px;
  double inverse_distance;  // from the camera
};

}  // namespace

Guesses unmatched(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& bundle, int wanted) {
  const size_t frames = bundle.cameras.size();
  std::vector<std::vector<Known>> known(frames);
  for (size_t i = 0; i < tracks.size(); ++i) {
    const InversePoint& point = bundle.points[i];
    for (const Observation& o : tracks[i]) {
      const double seen = point.seen_from(bundle.cameras[static_cast<size_t>(o.frame)].centre).norm();
      known[static_cast<size_t>(o.frame)].push_back({o.position_px, point.inverse_distance / seen});
    }
  }
  Guesses guesses;
  for (size_t frame = 0; frame < frames; ++frame) {
    if (known[frame].empty()) continue;
    const Features& features = sweep.features[frame];
    Occupied occupied(features, sweep.pixels(kApart));
    for (const Known& k : known[frame]) occupied.add(k.position_px);
    const Pose& pose = bundle.cameras[frame];
    int left = static_cast<int>(kTried * (wanted - static_cast<int>(known[frame].size())));
    for (int i = 0; i < features.size() && left > 0; ++i) {
      const Eigen::Vector2d p = features.from_middle(i);
      if (occupied.near(p)) continue;
      const Known& nearest =
          *std::min_element(known[frame].begin(), known[frame].end(), [&](const Known& a, const Known& b) {
            return (a.position_px - p).squaredNorm() < (b.position_px - p).squaredNorm();
          });
      if ((nearest.position_px - p).norm() > sweep.pixels(kNear)) continue;
      occupied.add(p);
      --left;
      const Eigen::Vector3d ray = pose.world_from_camera * ray_of(p, bundle.lens).homogeneous().normalized();
      const Eigen::Vector3d m = ray + nearest.inverse_distance * pose.centre;
      guesses.tracks.push_back({{static_cast<int>(frame), -1, p}});
      guesses.points.push_back({m.normalized(), nearest.inverse_distance / m.norm()});
    }
  }
  return guesses;
}

void empty_repeated(const MatchedSweep& sweep, size_t first, std::vector<Track>& tracks) {
  std::vector<Occupied> occupied;
  for (const Features& features : sweep.features) occupied.emplace_back(features, sweep.pixels(kSameThing));
  for (size_t i = 0; i < tracks.size(); ++i) {
    const auto taken = [&](const Observation& o) { return occupied[static_cast<size_t>(o.frame)].near(o.position_px); };
    if (i >= first && (tracks[i].size() < 2 || std::any_of(tracks[i].begin(), tracks[i].end(), taken)))
      tracks[i].clear();
    for (const Observation& o : tracks[i]) occupied[static_cast<size_t>(o.frame)].add(o.position_px);
  }
}

}  // namespace ldp
