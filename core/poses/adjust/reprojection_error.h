// Residuals of bundle adjustment as Ceres takes them: reprojection with its robust loss, and priors.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/poses/adjust/adjust_tuning.h"
#include "core/poses/adjust/bundle_adjustment.h"

namespace ldp::sfm {

template <int kColumns>
using Jacobian = Eigen::Map<Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>>;

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Cameras are parametrised by their rotation since the start, as Rodrigues parameters: g = axis * tan(angle / 2), that
// of the quaternion (1, g).
struct CameraRotation {
  explicit CameraRotation(const Eigen::Matrix3d& camera_from_world_at_start)
      : at_start(camera_from_world_at_start), camera_from_world(at_start) {}

  Eigen::Matrix3d at_start, camera_from_world;
  Eigen::Matrix3d by_change = 2 * Eigen::Matrix3d::Identity();  // the small turn on top of that of g when g changes

  void update(const Eigen::Vector3d& g) {
    const Eigen::Matrix3d m = cross_matrix(g);
    const double scale = 2 / (1 + g.squaredNorm());
    by_change = scale * (Eigen::Matrix3d::Identity() + m);
    camera_from_world = (Eigen::Matrix3d::Identity() + m * by_change) * at_start;
  }
};

// Directions are parametrised around where they are at the start: m = base + a e1 + b e2.
struct DirectionFrame {
  Eigen::Vector3d base, e1, e2;
};

// Cauchy's loss with a correction of second order (Triggs et al. 2000), weight * scale^2 * log(1 + x) with x the
// squared residual over scale^2. Ceres scales residuals and their derivatives by the slope of a loss like this and
// leaves its curvature out: steps are about half as long as they should be. Here residuals come scaled already, with as
// much of the curvature as keeps steps safe: their gradient is that of the loss, and along the residual the square of
// their derivative is less than what Ceres makes it by what the curvature leaves of it, but not below that share; the
// loss only tells what they cost. With a share of 1 it is what Ceres does.
class CorrectedCauchyLoss : public ceres::LossFunction {
 public:
  CorrectedCauchyLoss(double scale, double weight, double min_share)
      : squared_(scale * scale), weight_(weight), min_share_(min_share) {}

  // Scales the residual; gives what its derivatives are to be multiplied with.
  Eigen::Matrix2d apply(Eigen::Ref<Eigen::Vector2d> residual) const {
    const double squared = residual.squaredNorm(), x = squared / squared_, slope = std::sqrt(weight_ / (1 + x));
    const double shorter = std::sqrt(std::max((1 - x) / (1 + x), min_share_));
    Eigen::Matrix2d by = slope * Eigen::Matrix2d::Identity();
    if (squared > 0) by -= slope * (1 - shorter) / squared * residual * residual.transpose();
    residual *= slope / shorter;
    return by;
  }

  void Evaluate(double scaled, double rho[3]) const override {
    const double y = scaled / (squared_ * weight_);
    const double x =
        y < (1 - min_share_) / (2 * min_share_) ? y / (1 + y) : min_share_ * y / std::max(1 - min_share_ * y, 1e-12);
    rho[0] = weight_ * squared_ * std::log1p(x);
    rho[1] = 1;
    rho[2] = 0;
  }

 private:
  double squared_, weight_, min_share_;
};

// All blocks of the free model but points have so many parameters, of the others three: Ceres has a faster elimination
// for blocks of one size. The lens has three of its own; the others do nothing.
constexpr int kFreeBlock = 6;

// Reprojection of one point in one camera. Blocks: camera (turn, and centre if free), lens (log focal, k1, k2), point
// (a, b, and inverse distance unless the model is rotation).
template <MotionModel kModel>
class Reprojection : public ceres::CostFunction {
 public:
  Reprojection(const BundleObservation& seen, const CameraRotation& camera, const DirectionFrame& frame,
               const CorrectedCauchyLoss& loss)
      : position_px_(seen.position_px), weight_(seen.weight), camera_(camera), frame_(frame), loss_(loss) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {kBlock, kBlock, kPointSize};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const double *camera = blocks[0], *lens = blocks[1], *point = blocks[2];
    const double w = kModel == MotionModel::rotation ? 0 : point[kPointSize - 1];
    const Eigen::Matrix3d& r = camera_.camera_from_world;
    const Eigen::Vector3d direction = frame_.base + point[0] * frame_.e1 + point[1] * frame_.e2;
    const Eigen::Vector3d centre =
        kFree ? Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(camera + 3)) : Eigen::Vector3d::Zero();
    const Eigen::Vector3d turned = r * (direction - w * centre);  // what a turn of the camera turns
    const Eigen::Vector3d p = kFree ? turned : Eigen::Vector3d(turned - w * Eigen::Vector3d::UnitZ());
    if (!(p.z() > kMinDepth) || !(std::abs(lens[0]) < kMaxLogFocal)) return behind(residuals, jacobians);

    const Eigen::Vector2d n = p.head<2>() / p.z();
    const Distorted d = distort(n, lens[1], lens[2]);
    const double focal = std::exp(lens[0]);
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = weight_ * (focal * d.position - position_px_);
    const Eigen::Matrix2d scale = weight_ * loss_.apply(residual);
    if (!jacobians) return true;

    Eigen::Matrix<double, 2, 3> n_by_p;
    n_by_p << 1 / p.z(), 0, -n.x() / p.z(), 0, 1 / p.z(), -n.y() / p.z();
    const Eigen::Matrix<double, 2, 3> by_p = focal * scale * d.by_undistorted * n_by_p;
    if (jacobians[0]) {
      Jacobian<kBlock> by_camera(jacobians[0]);
      by_camera.template leftCols<3>() = -by_p * cross_matrix(turned) * camera_.by_change;
      if constexpr (kFree) by_camera.template rightCols<3>() = -w * by_p * r;
    }
    if (jacobians[1]) {
      Jacobian<kBlock> by_lens(jacobians[1]);
      by_lens.setZero();
      const Eigen::Vector2d outward = focal * d.squared * scale * n;
      by_lens.template leftCols<3>() << focal * scale * d.position, outward, d.squared * outward;
    }
    if (jacobians[2]) {
      Eigen::Matrix<double, 3, kPointSize> p_by_point;
      p_by_point.col(0) = r * frame_.e1;
      p_by_point.col(1) = r * frame_.e2;
      if (kFree) p_by_point.col(kPointSize - 1) = -r * centre;
      if (kModel == MotionModel::spherical) p_by_point.col(kPointSize - 1) = -Eigen::Vector3d::UnitZ();
      Jacobian<kPointSize> by_point(jacobians[2]);
      by_point = by_p * p_by_point;
    }
    return true;
  }

 private:
  bool behind(double* residuals, double** jacobians) const {
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual.setConstant(kBehindResidual_px);
    loss_.apply(residual);
    for (size_t i = 0; jacobians && i < parameter_block_sizes().size(); ++i) {
      if (jacobians[i]) std::fill_n(jacobians[i], 2 * parameter_block_sizes()[i], 0.0);
    }
    return true;
  }

  static constexpr bool kFree = kModel == MotionModel::free;
  static constexpr int kBlock = kFree ? kFreeBlock : 3, kPointSize = kModel == MotionModel::rotation ? 2 : 3;

  Eigen::Vector2d position_px_;
  double weight_;
  const CameraRotation& camera_;
  const DirectionFrame& frame_;
  const CorrectedCauchyLoss& loss_;
};

// A centre's place in its own camera is e_z, give or take sigma.
struct ArcPrior {
  Eigen::Matrix3d camera_from_world;  // at the start
  double sigma;
  template <typename T>
  bool operator()(const T* camera, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector> g(camera), centre(camera + 3);
    const Vector v = camera_from_world.cast<T>() * centre, across = g.cross(v);
    Eigen::Map<Vector> r(residual);
    r = v + T(2) / (T(1) + g.squaredNorm()) * (across + g.cross(across)) - Vector::UnitZ();
    r /= T(sigma);
    return true;
  }
};

// The rotation between two cameras is that one, give or take sigma. (Sines of the angles between: a step that is a
// right angle off is not drawn back.)
struct StepRotation {
  Eigen::Matrix3d a_from_world, b_from_world;  // at the start
  Eigen::Matrix3d b_from_a;
  double sigma_rad;

  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    const Eigen::Matrix<T, 3, 3> gap = turn(b) * b_from_world.cast<T>() * a_from_world.transpose().cast<T>() *
                                       turn(a).transpose() * b_from_a.transpose().cast<T>();
    const T scale = T(0.5 / sigma_rad);
    residual[0] = scale * (gap(2, 1) - gap(1, 2));
    residual[1] = scale * (gap(0, 2) - gap(2, 0));
    residual[2] = scale * (gap(1, 0) - gap(0, 1));
    return true;
  }

 private:
  // That of a camera since the start.
  template <typename T>
  static Eigen::Matrix<T, 3, 3> turn(const T* g) {
    Eigen::Matrix<T, 3, 3> m;
    m << T(0), -g[2], g[1], g[2], T(0), -g[0], -g[1], g[0], T(0);
    const T squared = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    return Eigen::Matrix<T, 3, 3>::Identity() + T(2) / (T(1) + squared) * (m + m * m);
  }
};

}  // namespace ldp::sfm
