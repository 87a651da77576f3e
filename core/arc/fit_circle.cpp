#include "core/arc/fit_circle.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/arc/arc_tuning.h"

namespace ldp::arcs {
namespace {

// centres = C + r Rot(psi) forward: least squares, linear. Where the cameras look bridges what a short path leaves
// open.
std::optional<Circle> circle_from_directions(const std::vector<FlatCamera>& cameras) {
  Eigen::Vector2d c = Eigen::Vector2d::Zero(), f = Eigen::Vector2d::Zero();
  for (const FlatCamera& camera : cameras) c += camera.centre, f += camera.forward;
  c /= static_cast<double>(cameras.size());
  f /= static_cast<double>(cameras.size());
  double along = 0, across = 0, norm = 0;
  for (const FlatCamera& camera : cameras) {
    const Eigen::Vector2d dc = camera.centre - c, df = camera.forward - f;
    along += dc.dot(df);
    across += df.x() * dc.y() - df.y() * dc.x();
    norm += df.squaredNorm();
  }
  if (norm < 1e-9 || along <= 0.3 * std::abs(across)) return std::nullopt;  // does not turn, or does not look outward
  const double a = along / norm, b = across / norm;
  return Circle{c - Eigen::Vector2d(a * f.x() - b * f.y(), b * f.x() + a * f.y()), std::hypot(a, b)};
}

// Kasa's algebraic circle: |p|^2 = 2 C.p + k, linear in C and k.
std::optional<Circle> circle_through_centres(const std::vector<FlatCamera>& cameras) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const FlatCamera& camera : cameras) {
    const Eigen::Vector3d row(2 * camera.centre.x(), 2 * camera.centre.y(), 1);
    a += row * row.transpose();
    b += row * camera.centre.squaredNorm();
  }
  const Eigen::Vector3d x = a.ldlt().solve(b);
  const double squared = x.z() + x.head<2>().squaredNorm();
  if (!x.allFinite() || squared <= 0) return std::nullopt;
  return Circle{x.head<2>(), std::sqrt(squared)};
}

// Residuals of the flat fit, in standard deviations: how far the centres lie off the circle, and how far they lie from
// the place on the circle where their camera's direction, turned by the sweep's common offset, would put them.
class CircleProblem {
 public:
  CircleProblem(const std::vector<FlatCamera>& cameras, double scale) : cameras_(cameras), scale_(scale) {}

  double cost(const Circle& circle) const {
    double sum = 0;
    visit(circle, [&](double residual, double sigma, const Eigen::Vector3d&) {
      const double s = residual / sigma;
      sum += 9 * std::log1p(s * s / 9);
    });
    return sum;
  }

  Circle refine(Circle circle) const {
    double damping = 1e-3, best = cost(circle);
    for (int i = 0; i < 100 && damping < 1e12; ++i) {
      Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      visit(circle, [&](double residual, double sigma, const Eigen::Vector3d& jacobian) {
        const double s = residual / sigma, weight = cauchy_weight(s * s / 9) / (sigma * sigma);
        h += weight * jacobian * jacobian.transpose();
        g += weight * residual * jacobian;
      });
      h.diagonal() *= 1 + damping;
      const Eigen::Vector3d step = -h.ldlt().solve(g);
      const Circle next{circle.centre + step.head<2>(), circle.radius + step.z()};
      const double value = next.radius > 0 && step.allFinite() ? cost(next) : best;
      if (value < best) {
        const bool settled = best - value < 1e-12 * best;
        circle = next, best = value, damping = std::max(damping / 10, 1e-12);
        if (settled) break;
      } else {
        damping *= 10;
      }
    }
    return circle;
  }

 private:
  double offset(const Circle& circle) const {  // common angle from the outward direction to where the cameras look
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const FlatCamera& camera : cameras_) {
      const Eigen::Vector2d q = camera.centre - circle.centre;
      sum +=
          Eigen::Vector2d(q.dot(camera.forward), q.x() * camera.forward.y() - q.y() * camera.forward.x()).normalized();
    }
    return std::atan2(sum.y(), sum.x());
  }

  // Jacobians are by (C.x, C.y, r); the common offset is re-estimated between steps.
  template <typename Visitor>
  void visit(const Circle& circle, const Visitor& visitor) const {
    const double turn = offset(circle), c = std::cos(turn), s = std::sin(turn);
    for (const FlatCamera& camera : cameras_) {
      const Eigen::Vector2d q = camera.centre - circle.centre;
      const double distance = std::max(q.norm(), 1e-12);
      visitor(distance - circle.radius, kRadialSigma * scale_,
              Eigen::Vector3d(-q.x() / distance, -q.y() / distance, -1));
      const Eigen::Vector2d& f = camera.forward;
      const Eigen::Vector2d tangent(-(c * f.y() - s * f.x()), c * f.x() + s * f.y());
      visitor(q.dot(tangent), kTangentialSigma * scale_, Eigen::Vector3d(-tangent.x(), -tangent.y(), 0));
    }
  }

  const std::vector<FlatCamera>& cameras_;
  double scale_;
};

bool looks_outward(const Circle& circle, const std::vector<FlatCamera>& cameras) {
  double sum = 0;
  for (const FlatCamera& camera : cameras) sum += (camera.centre - circle.centre).normalized().dot(camera.forward);
  return sum > 0;
}

struct Chord {
  Eigen::Vector2d mean, main;  // the centres' mean, and the path's main direction
  double length = 0;           // of its projection on that
};

Chord chord(const std::vector<FlatCamera>& cameras) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const FlatCamera& camera : cameras) mean += camera.centre;
  mean /= static_cast<double>(cameras.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const FlatCamera& camera : cameras) scatter += (camera.centre - mean) * (camera.centre - mean).transpose();
  const Eigen::Vector2d main = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  double low = 0, high = 0;
  for (const FlatCamera& camera : cameras) {
    low = std::min(low, main.dot(camera.centre - mean));
    high = std::max(high, main.dot(camera.centre - mean));
  }
  return {mean, main, high - low};
}

Eigen::Vector2d mean_forward(const std::vector<FlatCamera>& cameras) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const FlatCamera& camera : cameras) sum += camera.forward;
  return sum;
}

// Perpendicular to the path, to the side to which the cameras look.
Eigen::Vector2d across(const Chord& chord, const Eigen::Vector2d& forward) {
  const Eigen::Vector2d outward(-chord.main.y(), chord.main.x());
  return outward.dot(forward) < 0 ? Eigen::Vector2d(-outward) : outward;
}

}  // namespace

std::optional<Circle> fit_circle(const std::vector<FlatCamera>& cameras, double scale) {
  const CircleProblem problem(cameras, scale);
  std::optional<Circle> best;
  for (const std::optional<Circle>& start : {circle_from_directions(cameras), circle_through_centres(cameras)}) {
    if (!start || !looks_outward(*start, cameras)) continue;
    const Circle refined = problem.refine(*start);
    if (!looks_outward(refined, cameras)) continue;
    if (!best || problem.cost(refined) < problem.cost(*best)) best = refined;
  }
  return best;
}

double path_length(const std::vector<FlatCamera>& cameras) { return chord(cameras).length; }

bool goes_forward(const std::vector<FlatCamera>& cameras) {
  const Eigen::Vector2d forward = mean_forward(cameras);
  return across(chord(cameras), forward).dot(forward) < kForward * forward.norm();
}

Circle straight_circle(const std::vector<FlatCamera>& cameras) {
  const Chord path = chord(cameras);
  const Eigen::Vector2d forward = mean_forward(cameras);
  if (!goes_forward(cameras)) {
    const double radius = kLargestRadius * std::max(path.length, 1e-9);
    return {path.mean - radius * across(path, forward), radius};
  }
  double rear = 0;
  for (const FlatCamera& camera : cameras) rear = std::min(rear, forward.normalized().dot(camera.centre - path.mean));
  return {path.mean + rear * forward.normalized(), 0};
}

}  // namespace ldp::arcs
