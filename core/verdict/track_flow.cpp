#include "core/verdict/track_flow.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/exact_math.h"
#include "core/geometry/degrees.h"

namespace ldp {
namespace {

constexpr size_t kFewest = 8;        // points from which their flow is told
constexpr size_t kFarthestPart = 4;  // of the points, 1 .. kFewest: the part whose shift is taken for the turn's
constexpr double kLeastTurn =
    0.03;                  // of lines of sight, their deviation from the mean one: six degrees from end to end
constexpr int kReach = 3;  // photographs before, for parallax: what is far moves little from one to the next

struct Matched {
  std::vector<Eigen::Vector2d> before, after;  // pixels
  std::vector<double> squared_distance;        // from the camera after
};

using Pairs = std::vector<Matched>;  // of each camera, with the one `reach` before

Pairs pairs_of(const std::vector<ScenePoint>& points, const std::vector<std::vector<Eigen::Vector2d>>& sightings,
               const std::vector<Camera>& cameras, int reach) {
  Pairs pairs(cameras.size());
  for (size_t p = 0; p < points.size(); ++p) {
    const std::vector<int>& seen = points[p].cameras;
    for (size_t i = 0; i < seen.size(); ++i) {
      const auto before = std::find(seen.begin(), seen.end(), seen[i] - reach);
      if (before == seen.end()) continue;
      const auto camera = static_cast<size_t>(seen[i]);
      Matched& pair = pairs[camera];
      pair.before.push_back(sightings[p][static_cast<size_t>(before - seen.begin())]);
      pair.after.push_back(sightings[p][i]);
      const Eigen::Vector3d sight = points[p].position - cameras[camera].pose.centre;
      pair.squared_distance.push_back(exact_dot(sight, sight));
    }
  }
  return pairs;
}

double length(const Eigen::Vector2d& v) { return std::sqrt(v.x() * v.x() + v.y() * v.y()); }
double length(const Eigen::Vector3d& v) { return std::sqrt(exact_dot(v, v)); }

double mean_shift(const Matched& pair) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < pair.before.size(); ++i) sum += pair.after[i] - pair.before[i];
  return length(sum) / static_cast<double>(pair.before.size());
}

// Those of the points that are farthest: steps shift them least.
Matched farthest_of(const Matched& pair) {
  std::vector<double> sorted = pair.squared_distance;
  const auto rank = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() - sorted.size() / kFarthestPart);
  std::nth_element(sorted.begin(), rank, sorted.end());
  Matched farthest;
  for (size_t i = 0; i < pair.before.size(); ++i) {
    if (pair.squared_distance[i] < *rank) continue;
    farthest.before.push_back(pair.before[i]);
    farthest.after.push_back(pair.after[i]);
  }
  return farthest;
}

// Flow of normalised image positions that the cameras' turns leave, and then any small turn that explains most of it.
class LeftOver {
 public:
  LeftOver(const Matched& pair, const Camera& before, const Camera& after) {
    const Eigen::Matrix3d turn = before.pose.world_from_camera.transpose() * after.pose.world_from_camera;
    for (size_t i = 0; i < pair.before.size(); ++i) {
      const Eigen::Vector3d a = unproject(before.intrinsics, pair.before[i]);
      const Eigen::Vector3d b = exact_product(turn, unproject(after.intrinsics, pair.after[i]));
      if (b.z() <= 0) continue;
      at_.emplace_back(a.x(), a.y());
      flow_.emplace_back(b.x() / b.z() - a.x(), b.y() / b.z() - a.y());
    }
    take_turn_out();
  }

  // Adds the sums that tell parallax and whether it points away from the middle.
  void add_to(PhotoEvidence& photo) const {
    for (size_t i = 0; i < at_.size(); ++i) {
      photo.outward += at_[i].x() * flow_[i].x() + at_[i].y() * flow_[i].y();
      photo.sideward += length(at_[i]) * length(flow_[i]);
      photo.parallax_squares += flow_[i].x() * flow_[i].x() + flow_[i].y() * flow_[i].y();
      ++photo.parallax_points;
    }
  }

 private:
  // Columns: flow of a turn about the camera's x, y and z axis (Longuet-Higgins, Prazdny 1980).
  static Eigen::Matrix<double, 2, 3> of_turns(const Eigen::Vector2d& p) {
    Eigen::Matrix<double, 2, 3> m;
    m << p.x() * p.y(), -(1 + p.x() * p.x()), p.y(), 1 + p.y() * p.y(), -p.x() * p.y(), -p.x();
    return m;
  }

  void take_turn_out() {
    if (at_.size() < kFewest) return;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < at_.size(); ++i) {
      const Eigen::Matrix<double, 2, 3> m = of_turns(at_[i]);
      normal += m.transpose() * m;
      right += m.transpose() * flow_[i];
    }
    const Eigen::Vector3d turn = normal.inverse() * right;
    if (!turn.allFinite()) return;
    for (size_t i = 0; i < at_.size(); ++i) flow_[i] -= of_turns(at_[i]) * turn;
  }

  std::vector<Eigen::Vector2d> at_, flow_;
};

void measure_step(const Pose& before, const Pose& after, PhotoEvidence& photo) {
  double apart = 0;  // squared chord of the turn: 8 at half a turn
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d d = after.world_from_camera.col(axis) - before.world_from_camera.col(axis);
    apart += exact_dot(d, d);
  }
  photo.turn_deg =
      rounded(2 * std::atan2(std::sqrt(apart), std::sqrt(std::max(0.0, 8 - apart))) * kDegreesPerRadian, 8);
  const Eigen::Vector3d middle = before.world_from_camera.col(2) + after.world_from_camera.col(2);
  const Eigen::Vector3d way = after.centre - before.centre;
  photo.step = length(way);
  photo.forward = length(middle) > 0 ? exact_dot(way, middle) / length(middle) : 0;
}

// On an arc a camera moves where it turns to; around a thing that it looks at, the other way. The correlation.
double inward(const std::vector<Camera>& cameras) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), mean_sight = middle;
  const auto count = static_cast<double>(cameras.size());
  for (const Camera& camera : cameras)
    middle += camera.pose.centre / count, mean_sight += camera.pose.world_from_camera.col(2) / count;
  double both = 0, spread = 0, turned = 0;
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d way = camera.pose.centre - middle, turn = camera.pose.world_from_camera.col(2) - mean_sight;
    both += exact_dot(way, turn), spread += exact_dot(way, way), turned += exact_dot(turn, turn);
  }
  if (turned < count * kLeastTurn * kLeastTurn || spread == 0) return 0;
  return std::max(0.0, -both / std::sqrt(spread * turned));
}

}  // namespace

void measure_flow(const std::vector<ScenePoint>& points, const std::vector<std::vector<Eigen::Vector2d>>& sightings,
                  const std::vector<Camera>& cameras, SweepEvidence& evidence) {
  evidence.inward = inward(cameras);
  const Pairs neighbours = pairs_of(points, sightings, cameras, 1);
  for (size_t i = 1; i < cameras.size(); ++i) {
    PhotoEvidence& photo = evidence.photos[i];
    measure_step(cameras[i - 1].pose, cameras[i].pose, photo);
    photo.shared_points = static_cast<int>(neighbours[i].before.size());
    if (neighbours[i].before.size() < kFewest) continue;
    photo.shift = mean_shift(neighbours[i]) / cameras[i].intrinsics.width;
    photo.far_shift = mean_shift(farthest_of(neighbours[i])) / cameras[i].intrinsics.width;
    LeftOver(neighbours[i], cameras[i - 1], cameras[i]).add_to(photo);
  }
  const Pairs apart = pairs_of(points, sightings, cameras, kReach);
  for (size_t i = kReach; i < cameras.size(); ++i)
    if (apart[i].before.size() >= kFewest)
      LeftOver(apart[i], cameras[i - kReach], cameras[i]).add_to(evidence.photos[i]);
}

}  // namespace ldp
