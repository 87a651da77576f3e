#include "points.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

namespace ldp {
namespace {

constexpr double kLeastDepth = 2e-3;  // of a point before a camera, as a share of its distance from the origin: nearer,
                                      // it is in the camera
constexpr double kSamePlace_px = 2;   // two features of a frame that near are one thing with two orientations or scales

// Union-find over all features of all frames; every set keeps its members so that conflicts are seen before joining.
class Sets {
 public:
  explicit Sets(const std::vector<Features>& features) : features_(features) {
    for (const Features& f : features) {
      first_.push_back(static_cast<int>(parent_.size()));
      for (int i = 0; i < f.size(); ++i) {
        members_.push_back({{static_cast<int>(first_.size()) - 1, i, f.from_middle(i)}});
        parent_.push_back(static_cast<int>(parent_.size()));
      }
    }
  }

  void join(const Observation& a, const Observation& b) {
    int x = root(a), y = root(b);
    if (x == y || conflict(x, y)) return;
    if (members(x).size() < members(y).size()) std::swap(x, y);
    parent_[static_cast<size_t>(y)] = x;
    members(x).insert(members(x).end(), members(y).begin(), members(y).end());
    members(y).clear();
  }

  // Sets that span at least two frames, one observation (the first detected, i.e. the strongest) per frame.
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

  const Eigen::Vector2d& place(const Observation& o) const {
    return features_[static_cast<size_t>(o.frame)].positions[static_cast<size_t>(o.feature)];
  }

  bool conflict(int x, int y) {
    for (const Observation& p : members(x)) {
      for (const Observation& q : members(y)) {
        if (p.frame == q.frame && (place(p) - place(q)).norm() > kSamePlace_px) return true;
      }
    }
    return false;
  }

  const std::vector<Features>& features_;
  std::vector<int> first_, parent_;
  std::vector<std::vector<Observation>> members_;
};

// cross(bearing, m - w c) = 0 for every sighting: the eigenvector of least eigenvalue.
InversePoint triangulate_linearly(const std::vector<Sighting>& sightings) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector3d towards = Eigen::Vector3d::Zero();
  for (const Sighting& s : sightings) {
    const Eigen::Vector3d bearing = (s.camera_from_world.transpose() * s.position.homogeneous()).normalized();
    Eigen::Matrix<double, 3, 4> rows;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - bearing * bearing.transpose();
    rows.leftCols<3>() = across;
    rows.col(3) = -across * s.centre;
    normal += rows.transpose() * rows;
    towards += bearing;
  }
  if (normal(3, 3) < 1e-16) {  // all from one place, the origin: only the direction is seen
    const Eigen::Matrix3d across = normal.topLeftCorner<3, 3>();
    const Eigen::Vector3d m = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(across).eigenvectors().col(0);
    return {m.dot(towards) < 0 ? Eigen::Vector3d(-m) : m, 0};
  }
  Eigen::Vector4d h = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(normal).eigenvectors().col(0);
  if (h.head<3>().dot(towards) < 0) h = -h;
  const double length = std::max(h.head<3>().norm(), 1e-12);
  return {h.head<3>() / length, h[3] / length};
}

// Gauss-Newton on reprojection; parameters are two turns of the direction and the inverse distance.
InversePoint refine_point(InversePoint point, const std::vector<Sighting>& sightings) {
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d e1 = point.direction.unitOrthogonal(), e2 = point.direction.cross(e1);
    Eigen::Matrix3d h = 1e-12 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const Sighting& s : sightings) {
      const Eigen::Vector3d q = s.camera_from_world * point.seen_from(s.centre);
      if (q.z() <= 0) return point;
      Eigen::Matrix<double, 2, 3> by_q;
      by_q << 1 / q.z(), 0, -q.x() / (q.z() * q.z()), 0, 1 / q.z(), -q.y() / (q.z() * q.z());
      Eigen::Matrix3d q_by;
      q_by << s.camera_from_world * e1, s.camera_from_world * e2, -s.camera_from_world * s.centre;
      const Eigen::Matrix<double, 2, 3> jacobian = by_q * q_by;
      const Eigen::Vector2d residual = q.head<2>() / q.z() - s.position;
      h += jacobian.transpose() * jacobian;
      g += jacobian.transpose() * residual;
    }
    const Eigen::Vector3d step = -h.ldlt().solve(g);
    if (!step.allFinite()) return point;
    const Eigen::Vector3d direction = point.direction + step[0] * e1 + step[1] * e2;
    point = {direction.normalized(), (point.inverse_distance + step[2]) / direction.norm()};
    if (step.norm() < 1e-10) break;
  }
  return point;
}

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
  Sets sets(features);
  for (const Link& link : links) sets.join(link.a, link.b);
  return sets.tracks();
}

double sighting_error(const InversePoint& point, const Sighting& sighting) {
  const Eigen::Vector3d q = sighting.camera_from_world * point.seen_from(sighting.centre);
  if (q.z() < kLeastDepth) return std::numeric_limits<double>::infinity();
  return (q.head<2>() / q.z() - sighting.position).norm();
}

std::optional<InversePoint> triangulate_point(const std::vector<Sighting>& sightings) {
  const InversePoint point = refine_point(triangulate_linearly(sightings), sightings);
  for (const Sighting& s : sightings) {
    if (!(sighting_error(point, s) < std::numeric_limits<double>::infinity())) return std::nullopt;
  }
  return point;
}

std::optional<InversePoint> triangulate_point_robustly(const std::vector<Sighting>& sightings, double tolerance,
                                                       std::vector<bool>& used) {
  std::vector<size_t> kept(sightings.size());
  std::iota(kept.begin(), kept.end(), size_t{0});
  while (kept.size() >= 2) {
    std::vector<Sighting> chosen;
    for (const size_t i : kept) chosen.push_back(sightings[i]);
    const InversePoint point = refine_point(triangulate_linearly(chosen), chosen);
    size_t worst = 0;
    double error = 0;
    for (size_t i = 0; i < chosen.size(); ++i) {
      const double e = sighting_error(point, chosen[i]);
      if (e > error) error = e, worst = i;
    }
    if (error <= tolerance) {
      used.assign(sightings.size(), false);
      for (const size_t i : kept) used[i] = true;
      return point;
    }
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return std::nullopt;
}

}  // namespace ldp
