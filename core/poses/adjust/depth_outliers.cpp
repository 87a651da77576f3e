#include "core/poses/adjust/depth_outliers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ldp {
namespace {

constexpr size_t kNeighbours = 6;    // in the picture that are asked
constexpr double kMost = 0.25;       // of all points: where more seem so, it is the cameras that are wrong
constexpr double kSamePlace_px = 2;  // nearer than that, it is the same thing found twice

struct Seen {
  Eigen::Vector2d position_px;
  double inverse_distance;
};

std::vector<std::vector<Seen>> seen_by_frame(const std::vector<Track>& tracks, const Bundle& bundle) {
  std::vector<std::vector<Seen>> seen(bundle.cameras.size());
  for (size_t i = 0; i < tracks.size(); ++i) {
    for (const Observation& o : tracks[i])
      seen[static_cast<size_t>(o.frame)].push_back({o.position_px, bundle.points[i].inverse_distance});
  }
  for (std::vector<Seen>& frame : seen) {
    std::sort(frame.begin(), frame.end(),
              [](const Seen& a, const Seen& b) { return a.position_px.x() < b.position_px.x(); });
  }
  return seen;
}

// Inverse distances of the nearest in the picture.
class Nearest {
 public:
  void offer(double squared_px, double inverse_distance) {
    if (squared_px >= worst()) return;
    size_t i = std::min(count_, kNeighbours - 1);
    for (; i > 0 && nearest_[i - 1].first > squared_px; --i) nearest_[i] = nearest_[i - 1];
    nearest_[i] = {squared_px, inverse_distance};
    count_ = std::min(count_ + 1, kNeighbours);
  }
  double worst() const {
    return count_ < kNeighbours ? std::numeric_limits<double>::infinity() : nearest_.back().first;
  }
  bool full() const { return count_ == kNeighbours; }
  int like(double inverse_distance, double tolerance) const {
    return static_cast<int>(std::count_if(nearest_.begin(), nearest_.end(), [&](const auto& other) {
      return std::abs(other.second - inverse_distance) < tolerance;
    }));
  }

 private:
  std::array<std::pair<double, double>, kNeighbours> nearest_;
  size_t count_ = 0;
};

Nearest nearest(const std::vector<Seen>& seen, const Eigen::Vector2d& position_px) {
  Nearest found;
  const auto middle = std::lower_bound(seen.begin(), seen.end(), position_px.x(),
                                       [](const Seen& s, double x) { return s.position_px.x() < x; });
  const auto offer = [&](const Seen& s) {
    const double squared = (s.position_px - position_px).squaredNorm();
    if (squared > kSamePlace_px * kSamePlace_px) found.offer(squared, s.inverse_distance);
    return std::pow(s.position_px.x() - position_px.x(), 2) < found.worst();
  };
  for (auto right = middle; right != seen.end() && offer(*right);) ++right;
  for (auto left = middle; left != seen.begin() && offer(*std::prev(left));) --left;
  return found;
}

}  // namespace

std::vector<bool> loners(const std::vector<Track>& tracks, const Bundle& bundle, double tolerance_px) {
  const std::vector<std::vector<Seen>> seen = seen_by_frame(tracks, bundle);
  std::vector<bool> alone(tracks.size(), false);
  for (size_t i = 0; i < tracks.size(); ++i) {
    const Observation &first = tracks[i].front(), &last = tracks[i].back();
    const double base = (bundle.cameras[static_cast<size_t>(first.frame)].centre -
                         bundle.cameras[static_cast<size_t>(last.frame)].centre)
                            .norm();
    const double w = bundle.points[i].inverse_distance, tolerance = tolerance_px / (bundle.lens.focal_px * base);
    alone[i] = w < -tolerance;
    if (tracks[i].size() > 2 || alone[i]) continue;
    const Nearest around = nearest(seen[static_cast<size_t>(first.frame)], first.position_px);
    alone[i] = around.full() && around.like(w, tolerance) < 2;
  }
  if (static_cast<double>(std::count(alone.begin(), alone.end(), true)) > kMost * static_cast<double>(alone.size()))
    alone.assign(alone.size(), false);
  return alone;
}

}  // namespace ldp
