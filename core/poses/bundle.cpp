#include "bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glog/logging.h>

#include <array>
#include <cmath>

namespace ldp {
namespace {

constexpr double kNearest = 1e-3;         // smallest z of a point in camera axes that is still projected
constexpr double kLongestLog = 14;        // of a focal length in pixels: beyond, a step went astray
constexpr double kBehind_px = 1e3;        // residual of a point behind the camera
constexpr double kDistortionSigma = 0.1;  // of k1 and k2 about zero
constexpr double kHeldSigma = 1e-8;       // of what is held where it is

using RowMajor23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using RowMajor24 = Eigen::Matrix<double, 2, 4, Eigen::RowMajor>;

// Derivative of a left-multiplied small rotation quaternion (1, d) by d; columns are orthonormal.
Eigen::Matrix<double, 4, 3> quaternion_by_turn(const double* q) {
  Eigen::Matrix<double, 4, 3> j;
  j << -q[1], -q[2], -q[3], q[0], q[3], -q[2], -q[3], q[0], q[1], q[2], -q[1], q[0];
  return j;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Directions are parametrised around where they are at the start: m = base + a e1 + b e2.
struct DirectionFrame {
  Eigen::Vector3d base, e1, e2;
};

struct Distorted {
  Eigen::Vector2d position;  // focal length 1
  Eigen::Matrix2d by_undistorted;
  double squared = 0;
};

Distorted distort(const Eigen::Vector2d& n, double k1, double k2) {
  const double r2 = n.squaredNorm(), radial = 1 + r2 * (k1 + r2 * k2);
  return {radial * n, radial * Eigen::Matrix2d::Identity() + (2 * k1 + 4 * k2 * r2) * n * n.transpose(), r2};
}

// Reprojection of one point in one camera. Blocks: rotation (quaternion w x y z, camera from world), [centre, if free,]
// lens (log focal, k1, k2), point (a, b, and inverse distance unless the model is rotation).
template <Model kModel>
class Reprojection : public ceres::CostFunction {
 public:
  Reprojection(const Eigen::Vector2d& position_px, double weight, const DirectionFrame& frame)
      : position_px_(position_px), weight_(weight), frame_(frame) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = kFree ? std::vector<int>{4, 3, 3, 3} : std::vector<int>{4, 3, kPointSize};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const double *q = blocks[0], *lens = blocks[kLens], *point = blocks[kPoint];
    const double w = kModel == Model::rotation ? 0 : point[kPointSize - 1];
    const Eigen::Matrix3d r = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const Eigen::Vector3d direction = frame_.base + point[0] * frame_.e1 + point[1] * frame_.e2;
    const Eigen::Vector3d centre =
        kFree ? Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(blocks[1])) : Eigen::Vector3d::Zero();
    const Eigen::Vector3d turned = r * (direction - w * centre);  // what a turn of the camera turns
    const Eigen::Vector3d p = kFree ? turned : Eigen::Vector3d(turned - w * Eigen::Vector3d::UnitZ());
    if (!(p.z() > kNearest) || !(std::abs(lens[0]) < kLongestLog)) return behind(residuals, jacobians);

    const Eigen::Vector2d n = p.head<2>() / p.z();
    const Distorted d = distort(n, lens[1], lens[2]);
    const double focal = std::exp(lens[0]);
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = weight_ * (focal * d.position - position_px_);
    if (!jacobians) return true;

    Eigen::Matrix<double, 2, 3> n_by_p;
    n_by_p << 1 / p.z(), 0, -n.x() / p.z(), 0, 1 / p.z(), -n.y() / p.z();
    const Eigen::Matrix<double, 2, 3> by_p = weight_ * focal * d.by_undistorted * n_by_p;
    if (jacobians[0]) {
      const Eigen::Matrix<double, 2, 3> by_turn = -by_p * cross_matrix(turned);
      Eigen::Map<RowMajor24>(jacobians[0], 2, 4) = 2 * by_turn * quaternion_by_turn(q).transpose();
    }
    if (kFree && jacobians[1]) Eigen::Map<RowMajor23>(jacobians[1], 2, 3) = -w * by_p * r;
    if (jacobians[kLens]) {
      RowMajor23 by_lens;
      by_lens << focal * d.position, focal * d.squared * n, focal * d.squared * d.squared * n;
      Eigen::Map<RowMajor23>(jacobians[kLens], 2, 3) = weight_ * by_lens;
    }
    if (jacobians[kPoint]) {
      Eigen::Matrix<double, 3, kPointSize> p_by_point;
      p_by_point.col(0) = r * frame_.e1;
      p_by_point.col(1) = r * frame_.e2;
      if (kFree) p_by_point.col(kPointSize - 1) = -r * centre;
      if (kModel == Model::spherical) p_by_point.col(kPointSize - 1) = -Eigen::Vector3d::UnitZ();
      Eigen::Map<Eigen::Matrix<double, 2, kPointSize, Eigen::RowMajor>>(jacobians[kPoint], 2, kPointSize) =
          by_p * p_by_point;
    }
    return true;
  }

 private:
  bool behind(double* residuals, double** jacobians) const {
    residuals[0] = residuals[1] = kBehind_px;
    for (size_t i = 0; jacobians && i < parameter_block_sizes().size(); ++i) {
      if (jacobians[i]) std::fill_n(jacobians[i], 2 * parameter_block_sizes()[i], 0.0);
    }
    return true;
  }

  static constexpr bool kFree = kModel == Model::free;
  static constexpr int kLens = kFree ? 2 : 1, kPoint = kLens + 1, kPointSize = kModel == Model::rotation ? 2 : 3;

  Eigen::Vector2d position_px_;
  double weight_;
  DirectionFrame frame_;
};

// A centre's place in its own camera is e_z, give or take sigma.
struct ArcPrior {
  double sigma;
  template <typename T>
  bool operator()(const T* rotation, const T* centre, T* residual) const {
    T p[3];
    ceres::UnitQuaternionRotatePoint(rotation, centre, p);
    residual[0] = p[0] / sigma;
    residual[1] = p[1] / sigma;
    residual[2] = (p[2] - 1.0) / sigma;
    return true;
  }
};

// What is not refined is held by its prior instead of a manifold: all blocks but points then have three free
// parameters, for which Ceres has an elimination of fixed size, twice as fast as that of any size.
struct LensPrior {
  std::array<double, 3> mean;  // log focal, k1, k2
  double focal_sigma, distortion_sigma;
  template <typename T>
  bool operator()(const T* lens, T* residual) const {
    residual[0] = (lens[0] - mean[0]) / focal_sigma;
    residual[1] = (lens[1] - mean[1]) / distortion_sigma;
    residual[2] = (lens[2] - mean[2]) / distortion_sigma;
    return true;
  }
};

class StopCheck : public ceres::IterationCallback {
 public:
  explicit StopCheck(const Job& job) : job_(job) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return job_.stop.stop_requested() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const Job& job_;
};

// The parameters as Ceres wants them: flat blocks. All in one piece of memory, because Ceres goes through blocks in the
// order of their addresses, and the order of additions decides the last bits of their sums.
class Blocks {
 public:
  Blocks(size_t cameras, size_t points) : cameras_(cameras), values_(7 * cameras + 3 + 3 * points) {}

  double* rotation(size_t camera) { return values_.data() + 4 * camera; }  // quaternion w x y z, camera from world
  double* centre(size_t camera) { return values_.data() + 4 * cameras_ + 3 * camera; }
  double* lens() { return values_.data() + 7 * cameras_; }
  double* point(size_t point) { return values_.data() + 7 * cameras_ + 3 + 3 * point; }

  std::vector<DirectionFrame> frames;  // of the points

 private:
  size_t cameras_;
  std::vector<double> values_;
};

Blocks blocks_of(const Bundle& bundle) {
  Blocks blocks(bundle.cameras.size(), bundle.points.size());
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    const Pose& pose = bundle.cameras[i];
    const Eigen::Quaterniond q(Eigen::Matrix3d(pose.world_from_camera.transpose()));
    Eigen::Map<Eigen::Vector4d>(blocks.rotation(i), 4) = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
    Eigen::Map<Eigen::Vector3d>(blocks.centre(i), 3) = pose.centre;
  }
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    const InversePoint& point = bundle.points[i];
    const Eigen::Vector3d e1 = point.direction.unitOrthogonal();
    blocks.frames.push_back({point.direction, e1, point.direction.cross(e1)});
    blocks.point(i)[2] = point.inverse_distance;
  }
  Eigen::Map<Eigen::Vector3d>(blocks.lens(), 3) =
      Eigen::Vector3d(std::log(bundle.lens.focal_px), bundle.lens.k1, bundle.lens.k2);
  return blocks;
}

void take(Blocks& blocks, const BundleOptions& options, Bundle& bundle) {
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    const double* q = blocks.rotation(i);
    Pose& pose = bundle.cameras[i];
    pose.world_from_camera = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix().transpose();
    pose.centre = options.model == Model::free ? Eigen::Vector3d(blocks.centre(i))
                                               : Eigen::Vector3d(pose.world_from_camera.col(2));
  }
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    const double* p = blocks.point(i);
    const DirectionFrame& frame = blocks.frames[i];
    const Eigen::Vector3d m = frame.base + p[0] * frame.e1 + p[1] * frame.e2;
    bundle.points[i] = {m.normalized(), options.model == Model::rotation ? 0 : p[2] / m.norm()};
  }
  if (options.refine_focal) bundle.lens.focal_px = std::exp(blocks.lens()[0]);
  if (options.refine_distortion) bundle.lens.k1 = blocks.lens()[1], bundle.lens.k2 = blocks.lens()[2];
}

struct Losses {
  explicit Losses(const BundleOptions& options)
      : confirmed(options.loss_px), pair(&confirmed, options.pair_weight, ceres::DO_NOT_TAKE_OWNERSHIP) {}

  ceres::CauchyLoss confirmed;
  ceres::ScaledLoss pair;
};

std::vector<int> views_of_points(const Bundle& bundle) {
  std::vector<int> views(bundle.points.size(), 0);
  for (const BundleObservation& o : bundle.observations) ++views[static_cast<size_t>(o.point)];
  return views;
}

void add_residuals(const Bundle& bundle, const BundleOptions& options, Blocks& blocks, Losses& losses,
                   ceres::Problem& problem) {
  const std::vector<int> views = views_of_points(bundle);
  for (const BundleObservation& o : bundle.observations) {
    const size_t camera = static_cast<size_t>(o.camera), point = static_cast<size_t>(o.point);
    double *rotation = blocks.rotation(camera), *p = blocks.point(point), *lens = blocks.lens();
    const DirectionFrame& frame = blocks.frames[point];
    ceres::LossFunction* const loss =
        views[point] > 2 ? static_cast<ceres::LossFunction*>(&losses.confirmed) : &losses.pair;
    if (options.model == Model::rotation) {
      problem.AddResidualBlock(new Reprojection<Model::rotation>(o.position_px, o.weight, frame), loss, rotation, lens,
                               p);
    } else if (options.model == Model::spherical) {
      problem.AddResidualBlock(new Reprojection<Model::spherical>(o.position_px, o.weight, frame), loss, rotation, lens,
                               p);
    } else {
      problem.AddResidualBlock(new Reprojection<Model::free>(o.position_px, o.weight, frame), loss, rotation,
                               blocks.centre(camera), lens, p);
    }
  }
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    double* rotation = blocks.rotation(i);
    if (!problem.HasParameterBlock(rotation)) continue;
    problem.SetManifold(rotation, new ceres::QuaternionManifold);
    if (options.model == Model::free) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ArcPrior, 3, 4, 3>(new ArcPrior{options.arc_sigma}),
                               nullptr, rotation, blocks.centre(i));
    }
  }
}

// Turning the world changes no residual: without one camera held, rounding errors alone would say how it turns, and
// cameras would come out otherwise on every machine.
void hold_the_world(size_t cameras, Blocks& blocks, ceres::Problem& problem) {
  for (size_t i = 0; i < cameras; ++i) {
    double* rotation = blocks.rotation((i + cameras / 2) % cameras);
    if (!problem.HasParameterBlock(rotation)) continue;
    problem.SetParameterBlockConstant(rotation);
    return;
  }
}

void add_lens(const Bundle& bundle, const BundleOptions& options, Blocks& blocks, ceres::Problem& problem) {
  const FocalPrior prior = options.focal_prior.value_or(FocalPrior{bundle.lens.focal_px, 1e6});
  const LensPrior cost = {
      {std::log(options.refine_focal ? prior.focal_px : bundle.lens.focal_px),
       options.refine_distortion ? 0 : bundle.lens.k1, options.refine_distortion ? 0 : bundle.lens.k2},
      options.refine_focal ? prior.log_sigma : kHeldSigma,
      options.refine_distortion ? kDistortionSigma : kHeldSigma};
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<LensPrior, 3, 3>(new LensPrior(cost)), nullptr,
                           blocks.lens());
}

}  // namespace

BundleSummary adjust(Bundle& bundle, const BundleOptions& options, const Job& job) {
  job.check();
  FLAGS_minloglevel =
      google::GLOG_FATAL;  // Ceres tells of every step that it rejects, on stderr; the summary is enough
  if (bundle.observations.empty()) return {};
  Blocks blocks = blocks_of(bundle);
  Losses losses(options);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  add_residuals(bundle, options, blocks, losses, problem);
  hold_the_world(bundle.cameras.size(), blocks, problem);
  add_lens(bundle, options, blocks, problem);

  ceres::Solver::Options solver;
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    if (!problem.HasParameterBlock(blocks.point(i))) continue;
    ordering->AddElementToGroup(blocks.point(i), 0);
    if (options.in_front && options.model != Model::rotation) {
      blocks.point(i)[2] = std::max(blocks.point(i)[2], 0.0);
      problem.SetParameterLowerBound(blocks.point(i), 2, 0);
    }
  }
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    if (!problem.HasParameterBlock(blocks.rotation(i))) continue;
    ordering->AddElementToGroup(blocks.rotation(i), 1);
    if (options.model == Model::free) ordering->AddElementToGroup(blocks.centre(i), 1);
  }
  ordering->AddElementToGroup(blocks.lens(), 1);
  solver.linear_solver_ordering.reset(ordering);
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.num_threads = 1;
  solver.max_num_iterations = options.most_iterations;
  solver.function_tolerance = options.settled;
  solver.logging_type = ceres::SILENT;
  StopCheck stop(job);
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  job.check();
  take(blocks, options, bundle);
  return {summary.final_cost, static_cast<int>(summary.iterations.size()), summary.IsSolutionUsable()};
}

Eigen::Vector2d ray_of(const Eigen::Vector2d& position_px, const Lens& lens) {
  const Intrinsics k{0, 0, lens.focal_px, lens.focal_px, 0, 0, lens.k1, lens.k2, 0, 0};
  return unproject(k, position_px).head<2>();
}

Projection project_point(const Pose& camera, const Lens& lens, const InversePoint& point) {
  const Eigen::Vector3d p = camera.world_from_camera.transpose() * point.seen_from(camera.centre);
  if (p.z() < kNearest) return {};
  return {lens.focal_px * distort(p.head<2>() / p.z(), lens.k1, lens.k2).position, true};
}

}  // namespace ldp
