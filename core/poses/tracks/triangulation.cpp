#include "core/poses/tracks/triangulation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

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

// Gauss-Newton on reprojection; parameters are two rotations of the direction and the inverse distance.
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

double normalised_error(const InversePoint& point, const Sighting& sighting) {
  const Eigen::Vector3d q = sighting.camera_from_world * point.seen_from(sighting.centre);
  if (q.z() < kMinDepthShare) return std::numeric_limits<double>::infinity();
  return (q.head<2>() / q.z() - sighting.position).norm();
}

std::optional<InversePoint> triangulate_point(const std::vector<Sighting>& sightings) {
  const InversePoint point = refine_point(triangulate_linearly(sightings), sightings);
  for (const Sighting& s : sightings) {
    if (!(normalised_error(point, s) < std::numeric_limits<double>::infinity())) return std::nullopt;
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
      const double e = normalised_error(point, chosen[i]);
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

}  // namespace ldp::sfm
