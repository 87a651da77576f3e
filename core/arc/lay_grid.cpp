#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "core/arc/arc.h"
#include "core/arc/arc_tuning.h"
#include "core/base/exact_math.h"
#include "core/geometry/degrees.h"

namespace ldp {

using namespace arcs;

namespace {

struct InverseDepths {
  double far = 0, near = 0;
};

double percentile(std::vector<double>& values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<size_t>(rank)];
}

double length_scale(const Arc& arc) { return arc.radius > 0 ? arc.radius : 1; }

// Nearer than the cameras stray from the circle a depth from it means nothing.
double nearest_depth(const Arc& arc, const std::vector<Camera>& cameras) {
  double stray = 0;
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d q = arc.world_from_arc.transpose() * (camera.pose.centre - arc.centre);
    stray = std::max(stray, std::abs(q.head<2>().norm() - arc.radius));
  }
  return 2 * stray;
}

// Inverse depths of the farthest and the nearest thing that enough points surely lie on; none where there are not as
// many.
std::optional<InverseDepths> ends_for_sure(std::vector<double>& sure, size_t points) {
  const size_t fewest = std::max(kFewestSure, static_cast<size_t>(kSureShare * static_cast<double>(points)));
  if (sure.size() < fewest) return std::nullopt;
  const auto rank = static_cast<std::ptrdiff_t>(fewest - 1);
  const auto at = [&](auto order) {
    std::nth_element(sure.begin(), sure.begin() + rank, sure.end(), order);
    return sure[fewest - 1];
  };
  return InverseDepths{at(std::less<>()), at(std::greater<>())};
}

// From the points where the options leave it open. Points inside the circle of the ray origins have no depth.
InverseDepths depth_range(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                          const std::vector<ScenePoint>& points, const GridOptions& options) {
  std::vector<double> inverse, sure;
  for (const ScenePoint& point : points) {
    const double w = locate(grid, point.position).inverse_depth;
    if (!(w >= 0)) continue;
    inverse.push_back(w);
    if (point.cameras.size() >= kSureCameras) sure.push_back(w);
  }
  const double scale = length_scale(grid.arc);
  InverseDepths range{0, 1 / scale};
  if (!inverse.empty()) {
    range = {percentile(inverse, kLowestShare), percentile(inverse, 1 - kLowestShare)};
    if (const auto ends = ends_for_sure(sure, inverse.size()))
      range = {std::min(range.far, ends->far), std::max(range.near, ends->near)};
    range = {range.far / kMargin, range.near * kMargin};
    range.near = std::max(range.near, options.matched_near);
    range.near = std::min(range.near, 1 / std::max(nearest_depth(grid.arc, cameras), 1e-12));
    range.far = std::min(range.far, 0.5 * range.near);
  }
  range.near = rounded(range.near, kRangeBits, range.near);
  if (options.near_depth > 0) range.near = 1 / options.near_depth;
  range.near = std::max(range.near, 1 / (kFarRadii * scale));
  if (options.far_depth > 0) {
    range.far = 1 / options.far_depth;
  } else if (range.far * kFarRadii * scale < 1 || range.far < kFarLabels * range.near) {
    range.far = 0;
  } else {
    range.far = rounded(range.far, kRangeBits, range.near);
  }
  return range;
}

// Where a line of sight meets the cylinder of inverse depth w: angle from the camera's place on the arc, and v.
struct Sight {
  double theta = 0, v = 0;
};

bool meets(const PanoramaGrid& grid, const Pose& pose, const Eigen::Vector3d& ray_in_camera, double w, Sight& sight) {
  const Eigen::Matrix3d arc_from_world = grid.arc.world_from_arc.transpose();
  const Eigen::Vector3d o = arc_from_world * (pose.centre - grid.arc.centre);
  const Eigen::Vector3d d = arc_from_world * pose.world_from_camera * ray_in_camera;
  const double a = d.head<2>().squaredNorm(), horizontal = std::sqrt(a);
  if (horizontal < 1e-6 * d.norm()) return false;  // straight up
  if (w <= 0) {
    sight = {std::atan2(d.y(), d.x()), d.z() / horizontal};
    return true;
  }
  const double radius = grid.ray_radius() + 1 / w, b = o.head<2>().dot(d.head<2>());
  const double discriminant = b * b - a * (o.head<2>().squaredNorm() - radius * radius);
  if (discriminant < 0) return false;
  const double t = (-b + std::sqrt(discriminant)) / a;
  if (t <= 0) return false;
  const Eigen::Vector3d p = o + t * d;
  sight = {std::atan2(p.y(), p.x()), p.z() * w};
  return true;
}

struct Extent {
  double low = 0, high = 0;
  void take(double value) { low = std::min(low, value), high = std::max(high, value); }
  void round() { low = rounded(low, kBorderBits), high = rounded(high, kBorderBits); }
};

std::array<Eigen::Vector2d, 8> border(const Intrinsics& k) {
  const double w = k.width, h = k.height;
  return {{{0, 0}, {w / 2, 0}, {w, 0}, {0, h / 2}, {w, h / 2}, {0, h}, {w / 2, h}, {w, h}}};
}

// A straight path was given a huge circle: there a column as wide as a photo's pixel at infinity would be metres wide
// nearby, and the ends of the panorama would lie far beyond what is seen. The middle of the depth range rules instead.
double middle_depth(const PanoramaGrid& grid) { return 2 / (grid.w_far + grid.w_near); }
bool nearly_straight(const PanoramaGrid& grid) { return grid.ray_radius() > 4 * middle_depth(grid); }

double angular_pitch(const PanoramaGrid& grid, double pixel_rad) {
  const double depth = middle_depth(grid);
  return nearly_straight(grid) ? pixel_rad * depth / (grid.ray_radius() + depth) : pixel_rad;
}

// Everything that the cameras see at the range's two ends. What is very near spreads over ever more rows of the unit
// cylinder; rows beyond kTallest times what is seen far away are not followed.
void extend(const PanoramaGrid& grid, const std::vector<Camera>& cameras, Extent& theta, Extent& v) {
  Extent near_v;
  const double farthest = nearly_straight(grid) ? 1 / middle_depth(grid) : grid.w_far;
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d q = grid.arc.world_from_arc.transpose() * (camera.pose.centre - grid.arc.centre);
    const Eigen::Vector3d f = grid.arc.world_from_arc.transpose() * camera.pose.world_from_camera.col(2);
    const double place = grid.arc.radius > 0 ? std::atan2(q.y(), q.x()) : std::atan2(f.y(), f.x());
    for (const Eigen::Vector2d& corner : border(camera.intrinsics)) {
      const Eigen::Vector3d ray = unproject(camera.intrinsics, corner);
      for (const double w : {farthest, grid.w_near}) {
        Sight sight;
        if (!meets(grid, camera.pose, ray, w, sight)) continue;
        theta.take(place + std::remainder(sight.theta - place, kTurn));
        (w == farthest ? v : near_v).take(std::clamp(sight.v, -kSteepest, kSteepest));
      }
    }
  }
  v.take(std::max(near_v.low, kTallest * v.low));
  v.take(std::min(near_v.high, kTallest * v.high));
  theta.round();
  v.round();
}

// No panorama is wider than its photos side by side: more columns would only repeat what they hold.
int most_columns(const std::vector<Camera>& cameras) {
  int sum = 0;
  for (const Camera& camera : cameras) sum += camera.intrinsics.width;
  return sum;
}

// Nor has it more pixels than they have together.
double most_pixels(const std::vector<Camera>& cameras, const GridOptions& options) {
  double sum = 0;
  for (const Camera& camera : cameras) sum += static_cast<double>(camera.intrinsics.width) * camera.intrinsics.height;
  return sum / (options.pitch_px * options.pitch_px);
}

double focal_px(const std::vector<Camera>& cameras) {
  std::vector<double> focals;
  for (const Camera& camera : cameras) focals.push_back(camera.intrinsics.fx);
  return percentile(focals, 0.5);
}

void check(const std::vector<Camera>& cameras, const GridOptions& options) {
  if (cameras.empty()) throw std::logic_error("lay_grid needs at least one camera");
  if (!(options.pitch_px > 0)) throw std::logic_error("pitch_px must be positive");
  if (options.near_depth < 0 || options.far_depth < 0) throw std::logic_error("depths must not be negative");
  if (options.far_depth > 0 && options.near_depth >= options.far_depth) {
    throw std::logic_error("near_depth must be less than far_depth");
  }
}

}  // namespace

PanoramaGrid lay_grid(const Arc& arc, const std::vector<Camera>& cameras, const std::vector<ScenePoint>& points,
                      const GridOptions& options) {
  check(cameras, options);
  PanoramaGrid grid;
  grid.arc = arc;
  grid.rays = options.rays;
  grid.theta_pitch = 1, grid.v_pitch = 1;
  const auto take_range = [&](const GridOptions& from) {
    const InverseDepths range = depth_range(grid, cameras, points, from);
    grid.w_far = range.far, grid.w_near = range.near;
  };
  take_range(options);
  if (nearly_straight(grid)) {  // where the range rules the pitch, too, feature points alone tell it
    GridOptions told = options;
    told.matched_near = 0;
    take_range(told);
  }

  Extent theta{arc.theta_begin, arc.theta_end}, v;
  extend(grid, cameras, theta, v);
  const double pixel_rad = options.pitch_px / focal_px(cameras);
  grid.theta_pitch = angular_pitch(grid, pixel_rad);
  grid.v_pitch = pixel_rad;
  grid.theta_pitch = std::max(grid.theta_pitch, (theta.high - theta.low) * options.pitch_px / most_columns(cameras));
  const double coarser = std::sqrt((theta.high - theta.low) / grid.theta_pitch * (v.high - v.low) / grid.v_pitch /
                                   most_pixels(cameras, options));
  if (coarser > 1) grid.theta_pitch *= coarser, grid.v_pitch *= coarser;
  grid.wraps = arc.closed || theta.high - theta.low >= kTurn - grid.theta_pitch;
  if (grid.wraps) {
    grid.width = static_cast<int>(std::lround(kTurn / grid.theta_pitch));
    grid.theta_pitch = kTurn / grid.width;
    grid.theta_left = 0.5 * (arc.theta_begin + arc.theta_end) + std::numbers::pi;
  } else {
    grid.width = static_cast<int>(std::ceil((theta.high - theta.low) / grid.theta_pitch));
    grid.theta_left = 0.5 * (theta.low + theta.high + grid.width * grid.theta_pitch);
  }
  grid.height = static_cast<int>(std::ceil((v.high - v.low) / grid.v_pitch));
  grid.v_top = 0.5 * (v.low + v.high + grid.height * grid.v_pitch);
  return grid;
}

int columns_of_colour(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                      const std::vector<ScenePoint>& points) {
  std::vector<double> inverse;
  for (const ScenePoint& point : points) {
    const double w = locate(grid, point.position).inverse_depth;
    if (w >= 0) inverse.push_back(w);
  }
  const int widest = std::min(kWidest, most_columns(cameras));
  if (inverse.empty() || grid.width > widest / kMostColourColumns ||
      static_cast<double>(grid.width) * kMostColourColumns * grid.height > most_pixels(cameras, {}))
    return 1;
  const double w = rounded(percentile(inverse, 0.5), kRangeBits, grid.w_near);
  return std::clamp(static_cast<int>((grid.ray_radius() * w + 1) * grid.theta_pitch / grid.v_pitch), 1,
                    kMostColourColumns);
}

PanoramaGrid with_finer_columns(PanoramaGrid grid, int times) {
  grid.width *= times;
  grid.theta_pitch /= times;
  return grid;
}

PanoramaGrid part_of(PanoramaGrid grid, int x, int y, int width, int height) {
  grid.theta_left = grid.theta(x);
  grid.v_top = grid.v(y);
  grid.width = width;
  grid.height = height;
  return grid;
}

}  // namespace ldp
