#include "core/poses/adjust/depth_outliers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/poses/adjust/adjust_tuning.h"

namespace ldp::sfm {
namespace {

struct ImagePoint {
  Eigen::Vector2d position_px;
  double inverse_distance;
};

std::vector<std::vector<ImagePoint>> points_by_frame(const std::vector<Track>& tracks, const Bundle& bundle) {
  std::vector<std::vector<ImagePoint>> seen(bundle.cameras.size());
  for (size_t i = 0; i < tracks.size(); ++i) {
    for (const Observation& o : tracks[i])
      seen[static_cast<size_t>(o.frame)].push_back({o.position_px, bundle.points[i].inverse_distance});
  }
  for (std::vector<ImagePoint>& frame : seen) {
    std::sort(frame.begin(), frame.end(),
              [](const ImagePoint& a, const ImagePoint& b) { return a.position_px.x() < b.position_px.x(); });
  }
  return seen;
}

// Inverse distances of the nearest in the picture.
class NearestNeighbours {
 public:
  void offer(double squared_px, double inverse_distance) {
    if (squared_px >= worst()) return;
    size_t i = std::min(count_, kDepthNeighbours - 1);
    for (; i > 0 && nearest_[i - 1].first > squared_px; --i) nearest_[i] = nearest_[i - 1];
    nearest_[i] = {squared_px, inverse_distance};
    count_ = std::min(count_ + 1, kDepthNeighbours);
  }
  double worst() const {
    return count_ < kDepthNeighbours ? std::numeric_limits<double>::infinity() : nearest_.back().first;
  }
  bool full() const { return count_ == kDepthNeighbours; }
  int count_similar(double inverse_distance, double tolerance) const {
    return static_cast<int>(std::count_if(nearest_.begin(), nearest_.end(), [&](const auto& other) {
      return std::abs(other.second - inverse_distance) < tolerance;
    }));
  }

 private:
  std::array<std::pair<double, double>, kDepthNeighbours> nearest_;
  size_t count_ = 0;
};

NearestNeighbours nearest_neighbours(const std::vector<ImagePoint>& seen, const Eigen::Vector2d& position_px) {
  NearestNeighbours found;
  const auto middle = std::lower_bound(seen.begin(), seen.end(), position_px.x(),
                                       [](const ImagePoint& s, double x) { return s.position_px.x() < x; });
  const auto offer = [&](const ImagePoint& s) {
    const double squared = (s.position_px - position_px).squaredNorm();
    if (squared > kSameImagePoint_px * kSameImagePoint_px) found.offer(squared, s.inverse_distance);
    return std::pow(s.position_px.x() - position_px.x(), 2) < found.worst();
  };
  for (auto right = middle; right != seen.end() && offer(*right);) ++right;
  for (auto left = middle; left != seen.begin() && offer(*std::prev(left));) --left;
  return found;
}

}  // namespace

std::vector<bool> depth_outliers(const std::vector<Track>& tracks, const Bundle& bundle, double tolerance_px) {
  const std::vector<std::vector<ImagePoint>> seen = points_by_frame(tracks, bundle);
  std::vector<bool> outliers(tracks.size(), false);
  for (size_t i = 0; i < tracks.size(); ++i) {
    const Observation &first = tracks[i].front(), &last = tracks[i].back();
    const double base = (bundle.cameras[static_cast<size_t>(first.frame)].centre -
                         bundle.cameras[static_cast<size_t>(last.frame)].centre)
                            .norm();
    const double w = bundle.points[i].inverse_distance, tolerance = tolerance_px / (bundle.lens.focal_px * base);
    outliers[i] = w < -tolerance;
    if (tracks[i].size() > 2 || outliers[i]) continue;
    const NearestNeighbours around = nearest_neighbours(seen[static_cast<size_t>(first.frame)], first.position_px);
    outliers[i] = around.full() && around.count_similar(w, tolerance) < kMinSimilarNeighbours;
  }
  if (static_cast<double>(std::count(outliers.begin(), outliers.end(), true)) >
      kMaxDepthOutlierShare * static_cast<double>(outliers.size()))
    outliers.assign(outliers.size(), false);
  return outliers;
}

}  // namespace ldp::sfm
