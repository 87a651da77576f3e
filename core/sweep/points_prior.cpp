#include "core/sweep/points_prior.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <tuple>

#include "core/sweep/sweep_tuning.h"

namespace ldp::sweep {
namespace {

using namespace tuning;

struct Point {
  double x_px, y_px, label, weight;
};

// So coarse that no last bit of a sine matters.
double rounded(double value) { return std::floor(value * 1024 + 0.5) / 1024; }

// Sorted by column; each wherever, a turn on or back, it is within reach of the panorama.
std::vector<Point> located(const PanoramaGrid& grid, const std::vector<ScenePoint>& points, int labels) {
  std::vector<Point> found;
  const double last = labels - 1, range = grid.w_near - grid.w_far;
  for (const ScenePoint& point : points) {
    const PanoramaPosition at = locate(grid, point.position);
    const double label = rounded((at.inverse_depth - grid.w_far) / range * last), x_px = rounded(at.x_px);
    if (!(at.inverse_depth >= 0 && label >= -1 && label <= labels)) continue;
    const int more_views = std::clamp(static_cast<int>(point.cameras.size()) - 1, 1, kPointsMostViews);
    const double turn_px = rounded(2 * std::numbers::pi / grid.theta_pitch);
    for (const int turn : {-1, 0, 1}) {
      const double x = x_px + turn * turn_px;
      if (x > -kPointsReachPx && x < grid.width + kPointsReachPx)
        found.push_back({x, rounded(at.y_px), std::clamp(label, 0.0, last), static_cast<double>(more_views)});
    }
  }
  std::sort(found.begin(), found.end(), [](const Point& a, const Point& b) {
    return std::tie(a.x_px, a.y_px, a.label, a.weight) < std::tie(b.x_px, b.y_px, b.label, b.weight);
  });
  return found;
}

struct Vote {
  double label, weight;
};

PointsPrior::Expectation sum_up(std::vector<Vote>& votes) {
  double total = 0;
  for (const Vote& vote : votes) total += vote.weight;
  if (!(total > 0)) return {};
  std::sort(votes.begin(), votes.end(),
            [](const Vote& a, const Vote& b) { return std::tie(a.label, a.weight) < std::tie(b.label, b.weight); });
  double median = 0, below = 0;
  for (const Vote& vote : votes) {
    median = vote.label;
    below += vote.weight;
    if (below >= total / 2) break;
  }
  double spread = 0;
  for (const Vote& vote : votes) spread += vote.weight * std::abs(vote.label - median);
  spread /= total * kPointsSpread;
  const auto whole = [](double value) { return static_cast<int16_t>(std::floor(value + 0.5)); };
  return {whole(median * PointsPrior::kLabelSteps),
          whole(std::min(1.0, total) / (1 + spread * spread) * PointsPrior::kFull)};
}

}  // namespace

PointsPrior::PointsPrior(const PanoramaGrid& grid, const std::vector<ScenePoint>& points, int labels)
    : width_(grid.width),
      cells_((grid.width + kPointsCellPx - 1) / kPointsCellPx, (grid.height + kPointsCellPx - 1) / kPointsCellPx) {
  if (!(grid.w_near > grid.w_far)) return;
  const std::vector<Point> sorted = located(grid, points, labels);
  std::vector<Vote> votes;
  for (int column = 0; column < cells_.width; ++column) {
    const double x_px = (column + 0.5) * kPointsCellPx;
    const auto before = [](const Point& point, double x) { return point.x_px < x; };
    const auto begin = std::lower_bound(sorted.begin(), sorted.end(), x_px - kPointsReachPx, before);
    const auto end = std::lower_bound(begin, sorted.end(), x_px + kPointsReachPx, before);
    for (int row = 0; row < cells_.height; ++row) {
      const double y_px = (row + 0.5) * kPointsCellPx;
      votes.clear();
      for (auto point = begin; point != end; ++point) {
        const double dx = point->x_px - x_px, dy = point->y_px - y_px, distance2 = dx * dx + dy * dy;
        if (distance2 > kPointsReachPx * kPointsReachPx) continue;
        const double falls = 1 + distance2 / (kPointsNearPx * kPointsNearPx);
        votes.push_back({point->label, point->weight / (falls * falls)});
      }
      cells_.at(column, row) = sum_up(votes);
    }
  }
}

PointsPrior::Expectation PointsPrior::at(int x, int y) const {
  return cells_.at(x % width_ / kPointsCellPx, y / kPointsCellPx);
}

}  // namespace ldp::sweep
