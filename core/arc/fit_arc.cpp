#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "core/arc/arc.h"
#include "core/arc/arc_tuning.h"
#include "core/base/exact_math.h"
#include "core/base/job.h"

namespace ldp {

using namespace arcs;

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

double cauchy_weight(double squared) { return 1 / (1 + squared); }

double spread(const std::vector<Camera>& cameras, const Eigen::Vector3d& mean) {
  double sum = 0;
  for (const Camera& camera : cameras) sum += (camera.pose.centre - mean).squaredNorm();
  return std::sqrt(sum / static_cast<double>(cameras.size()));
}

Eigen::Vector3d mean_centre(const std::vector<Camera>& cameras) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) sum += camera.pose.centre;
  return sum / static_cast<double>(cameras.size());
}

// The axis is the direction to which the cameras' right axes, forward axes and the chords of their path are most nearly
// perpendicular, each weighed by how far hands let it stray; the cameras' ups give it its sign. Cauchy weights.
Eigen::Vector3d fit_axis(const std::vector<Camera>& cameras) {
  const Eigen::Vector3d middle = mean_centre(cameras);
  const double height_sigma = std::max(kHeightSigma * spread(cameras, middle), 1e-12);
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) up -= camera.pose.world_from_camera.col(1);
  Eigen::Vector3d axis = up.norm() > 1e-9 ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d::UnitZ();
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    const auto add = [&](const Eigen::Vector3d& witness, double sigma) {
      const double residual = witness.dot(axis) / (3 * sigma);
      scatter += cauchy_weight(residual * residual) / (sigma * sigma) * witness * witness.transpose();
    };
    for (const Camera& camera : cameras) {
      add(camera.pose.world_from_camera.col(0), kRollSigma_rad);
      add(camera.pose.world_from_camera.col(2), kPitchSigma_rad);
      add(camera.pose.centre - middle, height_sigma);
    }
    axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    if (axis.dot(up) < 0) axis = -axis;
  }
  return axis;
}

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
};

struct FlatCamera {
  Eigen::Vector2d centre, forward;  // in the arc's plane; forward is of unit length
};

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

Eigen::Vector3d rounded_direction(const Eigen::Vector3d& v) {
  const Eigen::Vector3d r(rounded(v.x(), kFitBits), rounded(v.y(), kFitBits), rounded(v.z(), kFitBits));
  return r / std::sqrt(exact_dot(r, r));
}

Circle rounded_circle(const Circle& circle) {
  const double scale = circle.radius > 0 ? circle.radius : 1;
  return {{rounded(circle.centre.x(), kFitBits, scale), rounded(circle.centre.y(), kFitBits, scale)},
          rounded(circle.radius, kFitBits, scale)};
}

// Axes of the arc's plane, the third one the given one.
Eigen::Matrix3d frame_around(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d& a = axis;
  const bool flat = std::abs(a.x()) < std::abs(a.z()) && std::abs(a.y()) < std::abs(a.z());
  const Eigen::Vector3d across = flat ? Eigen::Vector3d(0, -a.z(), a.y()) : Eigen::Vector3d(-a.y(), a.x(), 0);
  Eigen::Matrix3d frame;
  frame.col(0) = across / std::sqrt(exact_dot(across, across));
  const Eigen::Vector3d b = frame.col(0);
  frame.col(1) =
      Eigen::Vector3d(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x());
  frame.col(2) = a;
  return frame;
}

// The frame turned by an angle around its third axis.
Eigen::Matrix3d turned(const Eigen::Matrix3d& frame, double angle) {
  const auto [s, c] = exact_sine_cosine(angle);
  Eigen::Matrix3d result = frame;
  for (int i = 0; i < 3; ++i) {
    result(i, 0) = c * frame(i, 0) + s * frame(i, 1);
    result(i, 1) = c * frame(i, 1) - s * frame(i, 0);
  }
  return result;
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

// Length of the path's projection on its main direction, and that direction.
std::pair<double, Eigen::Vector2d> chord(const std::vector<FlatCamera>& cameras) {
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
  return {high - low, main};
}

// A straight path: the circle is so large that it hardly bends, and touches the path where the cameras stand, on the
// side away from where they look.
Circle straight_circle(const std::vector<FlatCamera>& cameras) {
  const auto [length, main] = chord(cameras);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), forward = Eigen::Vector2d::Zero();
  for (const FlatCamera& camera : cameras) mean += camera.centre, forward += camera.forward;
  mean /= static_cast<double>(cameras.size());
  Eigen::Vector2d outward(-main.y(), main.x());
  if (outward.dot(forward) < 0) outward = -outward;
  const double sideways = outward.dot(forward) / std::max(forward.norm(), 1e-12);
  if (sideways < 0.3) outward = forward.normalized();  // the camera moved along its line of sight
  const double radius = kLargestRadius * std::max(length, 1e-9);
  return {mean - radius * outward, radius};
}

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

// Directions of the cameras in one run that starts behind the widest gap; and that gap, and the next widest.
struct Angles {
  double low = 0, high = 0, gap = 0, step = 0;
};

Angles run_of_angles(const std::vector<Eigen::Vector2d>& directions) {
  Angles angles;
  std::vector<double> sorted;
  for (const Eigen::Vector2d& q : directions) sorted.push_back(std::atan2(q.y(), q.x()));
  std::sort(sorted.begin(), sorted.end());
  for (size_t i = 0; i < sorted.size(); ++i) {
    const bool last = i + 1 == sorted.size();
    const double next = last ? sorted.front() + kTurn : sorted[i + 1], gap = next - sorted[i];
    if (gap > angles.gap) {
      angles.step = angles.gap;
      angles.gap = gap;
      angles.low = last ? sorted.front() : sorted[i + 1];
    } else {
      angles.step = std::max(angles.step, gap);
    }
  }
  angles.high = angles.low + kTurn - angles.gap;
  return angles;
}

// The sweep is closed when what is missing of the turn is no more than a step that the hand has taken anyway, or
// little enough for the photos on both sides of it to overlap.
bool comes_back(const Angles& angles, double half_view) {
  return angles.gap < std::min(std::max(1.5 * angles.step, 1.2 * half_view), 1.5 * half_view);
}

void check(const std::vector<Camera>& cameras) {
  if (cameras.size() < 3) {
    throw Impossible("an arc needs at least 3 cameras, got " + std::to_string(cameras.size()));
  }
  for (const Camera& camera : cameras) {
    if (!camera.pose.centre.allFinite() || !camera.pose.world_from_camera.allFinite()) {
      throw std::runtime_error("camera " + camera.name + ": its pose is not a number");
    }
  }
}

}  // namespace

ArcFit fit_arc(const std::vector<Camera>& cameras) {
  check(cameras);
  const Eigen::Vector3d axis = rounded_direction(fit_axis(cameras)), middle = mean_centre(cameras);
  const Eigen::Matrix3d world_from_flat = frame_around(axis);

  std::vector<FlatCamera> flat;
  for (const Camera& camera : cameras) {
    const Eigen::Vector2d f = (world_from_flat.transpose() * camera.pose.world_from_camera.col(2)).head<2>();
    flat.push_back({(world_from_flat.transpose() * (camera.pose.centre - middle)).head<2>(), f.normalized()});
  }
  const double scale = spread(cameras, middle);
  const bool one_place = scale <= 1e-9 * std::max(1.0, middle.norm());
  std::optional<Circle> circle = one_place ? Circle{} : fit_circle(flat, scale);
  ArcFit fit;
  fit.straight = !circle || (!one_place && chord(flat).first < kStraightAngle_rad * circle->radius);
  const bool flat_path = fit.straight || (!one_place && circle->radius > kLargestRadius * chord(flat).first);
  if (flat_path) circle = straight_circle(flat);
  circle = rounded_circle(*circle);

  std::vector<double> heights;
  for (const Camera& camera : cameras) heights.push_back(exact_dot(axis, camera.pose.centre - middle));
  std::vector<double> sorted = heights;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double level = sorted[sorted.size() / 2];

  // The path's angles are those of the places on a circle, those of the lines of sight where the places hardly form
  // one; whether the sweep closes is a matter of the lines of sight.
  double squared = 0;
  std::vector<Eigen::Vector2d> places, sights;
  for (const FlatCamera& camera : flat) {
    places.push_back(camera.centre - circle->centre);
    sights.push_back(camera.forward);
    squared += std::pow(places.back().norm() - circle->radius, 2) / static_cast<double>(flat.size());
  }
  const bool round = flat_path || std::sqrt(squared) < kRoughest * circle->radius;
  const Angles of_sights = run_of_angles(sights), angles = round ? run_of_angles(places) : of_sights;
  const double zero = rounded(0.5 * (angles.low + angles.high), kFitBits);  // theta = 0 in the middle of the sweep
  Arc& arc = fit.arc;
  arc.centre = middle + exact_product(world_from_flat, {circle->centre.x(), circle->centre.y(), level});
  arc.world_from_arc = turned(world_from_flat, zero);
  arc.radius = circle->radius;
  arc.theta_begin = rounded(angles.low - zero, kFitBits);
  arc.theta_end = rounded(angles.high - zero, kFitBits);
  const Intrinsics& k = cameras.front().intrinsics;
  arc.closed = !fit.straight && comes_back(of_sights, std::atan2(0.5 * k.width, k.fx));
  if (arc.closed) {
    arc.theta_begin = -std::numbers::pi;
    arc.theta_end = std::numbers::pi;
  }
  for (size_t i = 0; i < cameras.size(); ++i) {
    fit.radial_residuals.push_back((flat[i].centre - circle->centre).norm() - circle->radius);
    fit.height_residuals.push_back(heights[i] - level);
  }
  return fit;
}

}  // namespace ldp
