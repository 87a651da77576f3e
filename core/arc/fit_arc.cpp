#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "core/arc/arc.h"
#include "core/arc/arc_tuning.h"
#include "core/arc/fit_circle.h"
#include "core/base/exact_math.h"
#include "core/base/job.h"
#include "core/geometry/degrees.h"

namespace ldp {

using namespace arcs;

namespace {

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
  fit.straight = !circle || (!one_place && path_length(flat) < kStraightAngle_rad * circle->radius);
  const bool flat_path = fit.straight || (!one_place && circle->radius > kLargestRadius * path_length(flat));
  if (flat_path) circle = straight_circle(flat);
  fit.forward = flat_path && circle->radius == 0;
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
  const bool round = (flat_path && !fit.forward) || (!flat_path && std::sqrt(squared) < kRoughest * circle->radius);
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
