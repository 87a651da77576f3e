#include "core/poses/start/spherical_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/poses/start/start_tuning.h"

namespace ldp::sfm {
namespace {

Eigen::Matrix3d rotation(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  return angle < 1e-12 ? Eigen::Matrix3d::Identity() : Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& r) {
  const Eigen::AngleAxisd angle_axis(r);
  return angle_axis.angle() * angle_axis.axis();
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// The rotation that brings the rays of a nearest to those of b (Kabsch), robustly.
Eigen::Matrix3d aligning_rotation(const std::vector<RayPair>& pairs) {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  double tolerance = 1;  // shrinks to kRotationParallax_rad: the first iterations must bridge the whole rotation
  for (int iteration = 0; iteration < kKabschIterations;
       ++iteration, tolerance = std::max(kRotationParallax_rad, 0.6 * tolerance)) {
    Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
    for (const RayPair& pair : pairs) {
      const Eigen::Vector3d a = pair.a.homogeneous().normalized(), b = pair.b.homogeneous().normalized();
      const double squared = (b - r * a).squaredNorm() / (tolerance * tolerance);
      m += b * a.transpose() / (1 + squared);
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
    r = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }
  return r;
}

double sampson(const Eigen::Matrix3d& e, const RayPair& pair) {
  const Eigen::Vector3d line_b = e * pair.a.homogeneous(), line_a = e.transpose() * pair.b.homogeneous();
  const double norm = line_b.head<2>().squaredNorm() + line_a.head<2>().squaredNorm();
  return pair.b.homogeneous().dot(line_b) / std::sqrt(std::max(norm, 1e-300));
}

Eigen::Matrix3d spherical_essential(const Eigen::Matrix3d& b_from_a) {
  const Eigen::Vector3d t = b_from_a.col(2) - Eigen::Vector3d::UnitZ();
  return cross_matrix(t / std::max(t.norm(), 1e-12)) * b_from_a;
}

double spherical_cost(const Eigen::Matrix3d& b_from_a, const std::vector<RayPair>& pairs, double tolerance) {
  const Eigen::Matrix3d e = spherical_essential(b_from_a);
  double sum = 0;
  for (const RayPair& pair : pairs) {
    const double s = sampson(e, pair) / tolerance;
    sum += std::log1p(s * s);
  }
  return sum / static_cast<double>(pairs.size());
}

// Prior of an outward-looking arc, before any epipolar line is looked at: cameras rotate about the axis that the
// pictures rotate about, by most of that angle. Few points, or narrow views, tell little else.
Eigen::Vector4d rotation_prior(const Eigen::Matrix3d& b_from_a, const Eigen::Vector3d& shown) {
  const Eigen::Vector3d own = rotation_vector(b_from_a);
  const double share = own.dot(shown) / std::max(shown.squaredNorm(), 1e-12);
  Eigen::Vector4d result;
  result << (share - kCameraTurnShare) / kCameraTurnShareSigma,
      (own - share * shown) / (kAxisSigma_rad + kAxisSigmaShare * shown.norm());
  return result;
}

// Levenberg-Marquardt over the rotation, derivatives by differences, Cauchy weights.
RelativeRotation refine(Eigen::Matrix3d r, const std::vector<RayPair>& pairs, const Eigen::Vector3d& shown,
                        double tolerance) {
  constexpr double kStep = 1e-6;
  const double say = kEffectiveMatches / static_cast<double>(pairs.size());
  const auto cost_of = [&](const Eigen::Matrix3d& at) {
    return kEffectiveMatches * spherical_cost(at, pairs, tolerance) + rotation_prior(at, shown).squaredNorm();
  };
  double cost = cost_of(r), damping = 1e-3;
  for (int i = 0; i < 20 && damping < 1e6; ++i) {
    const Eigen::Matrix3d e = spherical_essential(r);
    std::array<Eigen::Matrix3d, 3> turned;
    for (int axis = 0; axis < 3; ++axis) {
      turned[static_cast<size_t>(axis)] = spherical_essential(rotation(kStep * Eigen::Vector3d::Unit(axis)) * r);
    }
    const Eigen::Vector4d prior = rotation_prior(r, shown);
    Eigen::Matrix<double, 4, 3> prior_by_turn;
    for (int axis = 0; axis < 3; ++axis)
      prior_by_turn.col(axis) =
          (rotation_prior(rotation(kStep * Eigen::Vector3d::Unit(axis)) * r, shown) - prior) / kStep;
    Eigen::Matrix3d h = prior_by_turn.transpose() * prior_by_turn;
    Eigen::Vector3d g = prior_by_turn.transpose() * prior;
    for (const RayPair& pair : pairs) {
      const double residual = sampson(e, pair) / tolerance;
      Eigen::Vector3d jacobian;
      for (int axis = 0; axis < 3; ++axis)
        jacobian[axis] = (sampson(turned[static_cast<size_t>(axis)], pair) / tolerance - residual) / kStep;
      const double weight = say / (1 + residual * residual);
      h += weight * jacobian * jacobian.transpose();
      g += weight * residual * jacobian;
    }
    h.diagonal() *= 1 + damping;
    h.diagonal().array() += 1e-12;
    const Eigen::Matrix3d next = rotation(-h.ldlt().solve(g)) * r;
    const double value = cost_of(next);
    if (value < cost) {
      const bool settled = cost - value < 1e-6 * cost;
      r = next, cost = value, damping *= 0.1;
      if (settled) break;
    } else {
      damping *= 10;
    }
  }
  return {r, cost};
}

// Rotations along a spanning tree of the heaviest edges first (Prim); those that it does not reach keep the identity.
std::vector<Eigen::Matrix3d> spanning_tree_rotations(int count, int first, const std::vector<RotationEdge>& edges,
                                                     std::vector<bool>& reached) {
  std::vector<Eigen::Matrix3d> world(static_cast<size_t>(count), Eigen::Matrix3d::Identity());
  reached.assign(static_cast<size_t>(count), false);
  reached[static_cast<size_t>(first)] = true;
  for (int added = 1; added < count; ++added) {
    const RotationEdge* best = nullptr;
    for (const RotationEdge& edge : edges) {
      if (reached[static_cast<size_t>(edge.a)] == reached[static_cast<size_t>(edge.b)]) continue;
      if (!best || edge.weight > best->weight) best = &edge;
    }
    if (!best) break;
    const size_t a = static_cast<size_t>(best->a), b = static_cast<size_t>(best->b);
    if (reached[a]) {
      world[b] = world[a] * best->b_from_a.transpose();
      reached[b] = true;
    } else {
      world[a] = world[b] * best->b_from_a;
      reached[a] = true;
    }
  }
  return world;
}

// world_b b_from_a = world_a up to a small rotation of the world: a Laplace equation per axis. Gives a row per camera.
Eigen::MatrixXd rotation_corrections(const std::vector<Eigen::Matrix3d>& world, int first,
                                     const std::vector<RotationEdge>& edges, const std::vector<bool>& reached) {
  const auto count = static_cast<Eigen::Index>(world.size());
  Eigen::MatrixXd laplacian = 1e-9 * Eigen::MatrixXd::Identity(count, count);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 3);
  laplacian(first, first) += 1e9;
  for (const RotationEdge& edge : edges) {
    const size_t a = static_cast<size_t>(edge.a), b = static_cast<size_t>(edge.b);
    if (!reached[a] || !reached[b]) continue;
    const Eigen::Vector3d gap = rotation_vector(world[a] * (world[b] * edge.b_from_a).transpose());
    const double weight = edge.weight / (1 + gap.squaredNorm() / (kRotationTolerance_rad * kRotationTolerance_rad));
    laplacian(edge.a, edge.a) += weight;
    laplacian(edge.b, edge.b) += weight;
    laplacian(edge.a, edge.b) -= weight;
    laplacian(edge.b, edge.a) -= weight;
    right.row(edge.a) -= weight * gap;
    right.row(edge.b) += weight * gap;
  }
  return laplacian.ldlt().solve(right);
}

}  // namespace

RelativeRotation spherical_rotation(const std::vector<RayPair>& pairs, double tolerance) {
  const Eigen::Vector3d turn = rotation_vector(aligning_rotation(pairs));
  RelativeRotation best;
  bool first = true;
  for (const double share : {1.0, 0.75, 0.5}) {  // near scenes seem to turn by more than the camera does
    RelativeRotation candidate = refine(rotation(share * turn), pairs, turn, 4 * tolerance);
    candidate = refine(candidate.b_from_a, pairs, turn, tolerance);
    if (first || candidate.cost < best.cost) best = candidate;
    first = false;
  }
  best.cost = spherical_cost(best.b_from_a, pairs, tolerance);
  return best;
}

RelativeRotation pure_rotation(const std::vector<RayPair>& pairs) {
  RelativeRotation result{aligning_rotation(pairs), 0};
  for (const RayPair& pair : pairs) {
    const Eigen::Vector3d a = pair.a.homogeneous().normalized(), b = pair.b.homogeneous().normalized();
    result.cost +=
        std::log1p((b - result.b_from_a * a).squaredNorm() / (kRotationParallax_rad * kRotationParallax_rad));
  }
  result.cost /= static_cast<double>(pairs.size());
  return result;
}

std::vector<Eigen::Matrix3d> average_rotations(int count, int first, const std::vector<RotationEdge>& edges,
                                               std::vector<bool>& reached) {
  std::vector<Eigen::Matrix3d> world = spanning_tree_rotations(count, first, edges, reached);
  for (int iteration = 0; iteration < kMaxAveragingIterations; ++iteration) {
    const Eigen::MatrixXd corrections = rotation_corrections(world, first, edges, reached);
    for (size_t i = 0; i < world.size(); ++i)
      world[i] = rotation(corrections.row(static_cast<Eigen::Index>(i)).transpose()) * world[i];
    if (corrections.norm() < 1e-6) break;
  }
  return world;
}

}  // namespace ldp::sfm
