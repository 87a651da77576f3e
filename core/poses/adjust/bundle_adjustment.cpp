#include "core/poses/adjust/bundle_adjustment.h"

#include <glog/logging.h>

#include <array>
#include <cmath>
#include <mutex>

#include "core/poses/adjust/adjust_tuning.h"
#include "core/poses/adjust/reprojection_error.h"

namespace ldp::sfm {
namespace {

// What is not refined is held by its prior: a block held in part would have another size than the others.
template <size_t kSize>
struct Prior {
  std::array<double, kSize> mean, sigma;
  template <typename T>
  bool operator()(const T* block, T* residual) const {
    for (size_t i = 0; i < kSize; ++i) residual[i] = (block[i] - mean[i]) / sigma[i];
    return true;
  }
};

template <size_t kSize>
void add_prior(const std::array<double, kSize>& mean, const std::array<double, kSize>& sigma, double* block,
               ceres::Problem& problem) {
  constexpr int kBlock = static_cast<int>(kSize);
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Prior<kSize>, kBlock, kBlock>(new Prior<kSize>{mean, sigma}),
                           nullptr, block);
}

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
class ParameterBlocks {
 public:
  ParameterBlocks(size_t cameras, size_t points)
      : cameras_(cameras), values_(kFreeBlock * (cameras + 1) + 3 * points) {}

  double* camera(size_t camera) { return values_.data() + kFreeBlock * camera; }  // rotation since the start, centre
  double* lens() { return camera(cameras_); }
  double* point(size_t point) { return camera(cameras_ + 1) + 3 * point; }

  std::vector<CameraRotation> rotations;  // of the cameras
  std::vector<DirectionFrame> frames;     // of the points

  void update_rotations() {
    for (size_t i = 0; i < cameras_; ++i) rotations[i].update(Eigen::Map<const Eigen::Vector3d>(camera(i)));
  }

 private:
  size_t cameras_;
  std::vector<double> values_;
};

ParameterBlocks parameter_blocks(const Bundle& bundle) {
  ParameterBlocks blocks(bundle.cameras.size(), bundle.points.size());
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    blocks.rotations.emplace_back(bundle.cameras[i].world_from_camera.transpose());
    Eigen::Map<Eigen::Vector3d>(blocks.camera(i) + 3) = bundle.cameras[i].centre;
  }
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    const InversePoint& point = bundle.points[i];
    const Eigen::Vector3d e1 = point.direction.unitOrthogonal();
    blocks.frames.push_back({point.direction, e1, point.direction.cross(e1)});
    blocks.point(i)[2] = point.inverse_distance;
  }
  Eigen::Map<Eigen::Vector3d>(blocks.lens()) =
      Eigen::Vector3d(std::log(bundle.lens.focal_px), bundle.lens.k1, bundle.lens.k2);
  return blocks;
}

// All observations of a camera share its rotation.
class RotationUpdate : public ceres::EvaluationCallback {
 public:
  explicit RotationUpdate(ParameterBlocks& blocks) : blocks_(blocks) {}
  void PrepareForEvaluation(bool, bool new_place) override {
    if (new_place) blocks_.update_rotations();
  }

 private:
  ParameterBlocks& blocks_;
};

void write_back(ParameterBlocks& blocks, const BundleAdjustmentOptions& options, Bundle& bundle) {
  blocks.update_rotations();
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    const Eigen::Quaterniond q(blocks.rotations[i].camera_from_world);
    Pose& pose = bundle.cameras[i];
    pose.world_from_camera = q.normalized().toRotationMatrix().transpose();
    pose.centre = options.model == MotionModel::free
                      ? Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(blocks.camera(i) + 3))
                      : Eigen::Vector3d(pose.world_from_camera.col(2));
  }
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    const double* p = blocks.point(i);
    const DirectionFrame& frame = blocks.frames[i];
    const Eigen::Vector3d m = frame.base + p[0] * frame.e1 + p[1] * frame.e2;
    bundle.points[i] = {m.normalized(), options.model == MotionModel::rotation ? 0 : p[2] / m.norm()};
  }
  if (options.refine_focal) bundle.lens.focal_px = std::exp(blocks.lens()[0]);
  if (options.refine_distortion) bundle.lens.k1 = blocks.lens()[1], bundle.lens.k2 = blocks.lens()[2];
}

struct Losses {
  explicit Losses(const BundleAdjustmentOptions& options)
      : multi_view(options.loss_px, 1, options.correct_curvature ? kMinCurvatureShare : 1),
        two_view(options.loss_px, options.two_view_weight, options.correct_curvature ? kMinCurvatureShare : 1) {}

  CorrectedCauchyLoss multi_view, two_view;
};

std::vector<int> track_lengths(const Bundle& bundle) {
  std::vector<int> views(bundle.points.size(), 0);
  for (const BundleObservation& o : bundle.observations) ++views[static_cast<size_t>(o.point)];
  return views;
}

ceres::CostFunction* reprojection(MotionModel model, const BundleObservation& o, const ParameterBlocks& blocks,
                                  const CorrectedCauchyLoss& loss) {
  const CameraRotation& camera = blocks.rotations[static_cast<size_t>(o.camera)];
  const DirectionFrame& frame = blocks.frames[static_cast<size_t>(o.point)];
  if (model == MotionModel::rotation) return new Reprojection<MotionModel::rotation>(o, camera, frame, loss);
  if (model == MotionModel::spherical) return new Reprojection<MotionModel::spherical>(o, camera, frame, loss);
  return new Reprojection<MotionModel::free>(o, camera, frame, loss);
}

void add_step_priors(const BundleAdjustmentOptions& options, ParameterBlocks& blocks, ceres::Problem& problem) {
  for (const StepPrior& step : options.step_priors) {
    const size_t a = static_cast<size_t>(step.a), b = static_cast<size_t>(step.b);
    if (!problem.HasParameterBlock(blocks.camera(a)) || !problem.HasParameterBlock(blocks.camera(b))) continue;
    auto* const turn =
        new StepRotation{blocks.rotations[a].at_start, blocks.rotations[b].at_start, step.b_from_a, step.sigma_rad};
    ceres::CostFunction* cost = nullptr;
    if (options.model == MotionModel::free)
      cost = new ceres::AutoDiffCostFunction<StepRotation, 3, kFreeBlock, kFreeBlock>(turn);
    else
      cost = new ceres::AutoDiffCostFunction<StepRotation, 3, 3, 3>(turn);
    problem.AddResidualBlock(cost, nullptr, blocks.camera(a), blocks.camera(b));
  }
}

void add_residuals(const Bundle& bundle, const BundleAdjustmentOptions& options, ParameterBlocks& blocks,
                   Losses& losses, ceres::Problem& problem) {
  const std::vector<int> views = track_lengths(bundle);
  for (const BundleObservation& o : bundle.observations) {
    const size_t camera = static_cast<size_t>(o.camera), point = static_cast<size_t>(o.point);
    CorrectedCauchyLoss& loss = views[point] > 2 ? losses.multi_view : losses.two_view;
    problem.AddResidualBlock(reprojection(options.model, o, blocks, loss), &loss, blocks.camera(camera), blocks.lens(),
                             blocks.point(point));
  }
  if (options.model != MotionModel::rotation) add_step_priors(options, blocks, problem);
  if (options.model != MotionModel::free) return;
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    if (!problem.HasParameterBlock(blocks.camera(i))) continue;
    auto* const prior = new ArcPrior{blocks.rotations[i].at_start, options.arc_sigma};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ArcPrior, 3, kFreeBlock>(prior), nullptr,
                             blocks.camera(i));
  }
}

// Gauge freedom: turning the world changes no residual. Without one camera held, rounding errors alone would say how it
// turns, and cameras would come out otherwise on every machine.
void fix_gauge(size_t cameras, MotionModel model, ParameterBlocks& blocks, ceres::Problem& problem) {
  for (size_t i = 0; i < cameras; ++i) {
    double* camera = blocks.camera((i + cameras / 2) % cameras);
    if (!problem.HasParameterBlock(camera)) continue;
    if (model == MotionModel::free) {
      constexpr double kAny = 1e6;
      add_prior<kFreeBlock>({}, {kFixedSigma, kFixedSigma, kFixedSigma, kAny, kAny, kAny}, camera, problem);
    } else {
      problem.SetParameterBlockConstant(camera);
    }
    return;
  }
}

void add_lens_prior(const Bundle& bundle, const BundleAdjustmentOptions& options, ParameterBlocks& blocks,
                    ceres::Problem& problem) {
  const FocalPrior prior = options.focal_prior.value_or(FocalPrior{bundle.lens.focal_px, 1e6});
  const double log_focal = std::log(options.refine_focal ? prior.focal_px : bundle.lens.focal_px);
  const double k1 = options.refine_distortion ? 0 : bundle.lens.k1, k2 = options.refine_distortion ? 0 : bundle.lens.k2;
  const double focal_sigma = options.refine_focal ? prior.log_sigma : kFixedSigma;
  const double distortion_sigma = options.refine_distortion ? kDistortionSigma : kFixedSigma;
  if (options.model == MotionModel::free) {
    add_prior<kFreeBlock>({log_focal, k1, k2, 0, 0, 0}, {focal_sigma, distortion_sigma, distortion_sigma, 1, 1, 1},
                          blocks.lens(), problem);
  } else {
    add_prior<3>({log_focal, k1, k2}, {focal_sigma, distortion_sigma, distortion_sigma}, blocks.lens(), problem);
  }
}

// Points are eliminated first (Schur complement), then cameras and lens together.
ceres::ParameterBlockOrdering* elimination_order(const Bundle& bundle, const ceres::Problem& problem,
                                                 ParameterBlocks& blocks) {
  auto* const ordering = new ceres::ParameterBlockOrdering;
  for (size_t i = 0; i < bundle.points.size(); ++i) {
    if (problem.HasParameterBlock(blocks.point(i))) ordering->AddElementToGroup(blocks.point(i), 0);
  }
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    if (problem.HasParameterBlock(blocks.camera(i))) ordering->AddElementToGroup(blocks.camera(i), 1);
  }
  ordering->AddElementToGroup(blocks.lens(), 1);
  return ordering;
}

void keep_points_in_front(size_t points, ParameterBlocks& blocks, ceres::Problem& problem) {
  for (size_t i = 0; i < points; ++i) {
    if (!problem.HasParameterBlock(blocks.point(i))) continue;
    blocks.point(i)[2] = std::max(blocks.point(i)[2], 0.0);
    problem.SetParameterLowerBound(blocks.point(i), 2, 0);
  }
}

ceres::Solver::Options solver_options(const BundleAdjustmentOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.num_threads = 1;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.initial_trust_region_radius = options.initial_trust_region_radius;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

BundleAdjustmentSummary adjust_bundle(Bundle& bundle, const BundleAdjustmentOptions& options, const Job& job) {
  job.check();
  static std::once_flag quiet;  // Ceres tells of every step that it rejects, on stderr; the summary is enough
  std::call_once(quiet, [] { FLAGS_minloglevel = google::GLOG_FATAL; });
  if (bundle.observations.empty()) return {};
  ParameterBlocks blocks = parameter_blocks(bundle);
  Losses losses(options);
  ceres::Problem::Options setup;
  setup.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  RotationUpdate callback(blocks);
  setup.evaluation_callback = &callback;
  ceres::Problem problem(setup);
  add_residuals(bundle, options, blocks, losses, problem);
  fix_gauge(bundle.cameras.size(), options.model, blocks, problem);
  add_lens_prior(bundle, options, blocks, problem);

  if (options.enforce_cheirality && options.model != MotionModel::rotation)
    keep_points_in_front(bundle.points.size(), blocks, problem);

  ceres::Solver::Options solver = solver_options(options);
  solver.linear_solver_ordering.reset(elimination_order(bundle, problem, blocks));
  StopCheck stop(job);
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  job.check();
  write_back(blocks, options, bundle);
  return {summary.final_cost, static_cast<int>(summary.iterations.size()), summary.IsSolutionUsable()};
}

}  // namespace ldp::sfm
