#include "core/poses/adjust/bundle_adjustment.h"

#include <glog/logging.h>

#include <array>
#include <cmath>
#include <mutex>

#include "core/poses/adjust/reprojection_error.h"

namespace ldp {
namespace {

constexpr double kDistortionSigma = 0.1;  // of k1 and k2 about zero
constexpr double kHeldSigma = 1e-8;       // of what is held where it is
constexpr double kBoldly = 0.65;          // of CauchySteps: from 0.8 to 0.5 on the last rounds take a third fewer steps

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
class Blocks {
 public:
  Blocks(size_t cameras, size_t points) : cameras_(cameras), values_(kFreeBlock * (cameras + 1) + 3 * points) {}

  double* camera(size_t camera) { return values_.data() + kFreeBlock * camera; }  // turn since the start, centre
  double* lens() { return camera(cameras_); }
  double* point(size_t point) { return camera(cameras_ + 1) + 3 * point; }

  std::vector<Turned> turned;          // of the cameras
  std::vector<DirectionFrame> frames;  // of the points

  void turn() {
    for (size_t i = 0; i < cameras_; ++i) turned[i].turn(Eigen::Map<const Eigen::Vector3d>(camera(i)));
  }

 private:
  size_t cameras_;
  std::vector<double> values_;
};

Blocks blocks_of(const Bundle& bundle) {
  Blocks blocks(bundle.cameras.size(), bundle.points.size());
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    blocks.turned.emplace_back(bundle.cameras[i].world_from_camera.transpose());
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

// All observations of a camera share how it has turned.
class TurnOnce : public ceres::EvaluationCallback {
 public:
  explicit TurnOnce(Blocks& blocks) : blocks_(blocks) {}
  void PrepareForEvaluation(bool, bool new_place) override {
    if (new_place) blocks_.turn();
  }

 private:
  Blocks& blocks_;
};

void take(Blocks& blocks, const BundleOptions& options, Bundle& bundle) {
  blocks.turn();
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    const Eigen::Quaterniond q(blocks.turned[i].camera_from_world);
    Pose& pose = bundle.cameras[i];
    pose.world_from_camera = q.normalized().toRotationMatrix().transpose();
    pose.centre = options.model == Model::free
                      ? Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(blocks.camera(i) + 3))
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
      : confirmed(options.loss_px, 1, options.near_the_end ? kBoldly : 1),
        pair(options.loss_px, options.pair_weight, options.near_the_end ? kBoldly : 1) {}

  CauchySteps confirmed, pair;
};

std::vector<int> views_of_points(const Bundle& bundle) {
  std::vector<int> views(bundle.points.size(), 0);
  for (const BundleObservation& o : bundle.observations) ++views[static_cast<size_t>(o.point)];
  return views;
}

ceres::CostFunction* reprojection(Model model, const BundleObservation& o, const Blocks& blocks,
                                  const CauchySteps& loss) {
  const Turned& camera = blocks.turned[static_cast<size_t>(o.camera)];
  const DirectionFrame& frame = blocks.frames[static_cast<size_t>(o.point)];
  if (model == Model::rotation) return new Reprojection<Model::rotation>(o, camera, frame, loss);
  if (model == Model::spherical) return new Reprojection<Model::spherical>(o, camera, frame, loss);
  return new Reprojection<Model::free>(o, camera, frame, loss);
}

void add_residuals(const Bundle& bundle, const BundleOptions& options, Blocks& blocks, Losses& losses,
                   ceres::Problem& problem) {
  const std::vector<int> views = views_of_points(bundle);
  for (const BundleObservation& o : bundle.observations) {
    const size_t camera = static_cast<size_t>(o.camera), point = static_cast<size_t>(o.point);
    CauchySteps& loss = views[point] > 2 ? losses.confirmed : losses.pair;
    problem.AddResidualBlock(reprojection(options.model, o, blocks, loss), &loss, blocks.camera(camera), blocks.lens(),
                             blocks.point(point));
  }
  if (options.model != Model::free) return;
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    if (!problem.HasParameterBlock(blocks.camera(i))) continue;
    auto* const prior = new ArcPrior{blocks.turned[i].at_start, options.arc_sigma};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ArcPrior, 3, kFreeBlock>(prior), nullptr,
                             blocks.camera(i));
  }
}

// Turning the world changes no residual: without one camera held, rounding errors alone would say how it turns, and
// cameras would come out otherwise on every machine.
void hold_the_world(size_t cameras, Model model, Blocks& blocks, ceres::Problem& problem) {
  for (size_t i = 0; i < cameras; ++i) {
    double* camera = blocks.camera((i + cameras / 2) % cameras);
    if (!problem.HasParameterBlock(camera)) continue;
    if (model == Model::free) {
      constexpr double kAny = 1e6;
      add_prior<kFreeBlock>({}, {kHeldSigma, kHeldSigma, kHeldSigma, kAny, kAny, kAny}, camera, problem);
    } else {
      problem.SetParameterBlockConstant(camera);
    }
    return;
  }
}

void add_lens(const Bundle& bundle, const BundleOptions& options, Blocks& blocks, ceres::Problem& problem) {
  const FocalPrior prior = options.focal_prior.value_or(FocalPrior{bundle.lens.focal_px, 1e6});
  const double log_focal = std::log(options.refine_focal ? prior.focal_px : bundle.lens.focal_px);
  const double k1 = options.refine_distortion ? 0 : bundle.lens.k1, k2 = options.refine_distortion ? 0 : bundle.lens.k2;
  const double focal_sigma = options.refine_focal ? prior.log_sigma : kHeldSigma;
  const double distortion_sigma = options.refine_distortion ? kDistortionSigma : kHeldSigma;
  if (options.model == Model::free) {
    add_prior<kFreeBlock>({log_focal, k1, k2, 0, 0, 0}, {focal_sigma, distortion_sigma, distortion_sigma, 1, 1, 1},
                          blocks.lens(), problem);
  } else {
    add_prior<3>({log_focal, k1, k2}, {focal_sigma, distortion_sigma, distortion_sigma}, blocks.lens(), problem);
  }
}

}  // namespace

BundleSummary adjust(Bundle& bundle, const BundleOptions& options, const Job& job) {
  job.check();
  static std::once_flag quiet;  // Ceres tells of every step that it rejects, on stderr; the summary is enough
  std::call_once(quiet, [] { FLAGS_minloglevel = google::GLOG_FATAL; });
  if (bundle.observations.empty()) return {};
  Blocks blocks = blocks_of(bundle);
  Losses losses(options);
  ceres::Problem::Options setup;
  setup.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  TurnOnce callback(blocks);
  setup.evaluation_callback = &callback;
  ceres::Problem problem(setup);
  add_residuals(bundle, options, blocks, losses, problem);
  hold_the_world(bundle.cameras.size(), options.model, blocks, problem);
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
    if (problem.HasParameterBlock(blocks.camera(i))) ordering->AddElementToGroup(blocks.camera(i), 1);
  }
  ordering->AddElementToGroup(blocks.lens(), 1);
  solver.linear_solver_ordering.reset(ordering);
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.num_threads = 1;
  solver.max_num_iterations = options.most_iterations;
  solver.function_tolerance = options.settled;
  solver.initial_trust_region_radius = options.first_trust;
  solver.logging_type = ceres::SILENT;
  StopCheck stop(job);
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  job.check();
  take(blocks, options, bundle);
  return {summary.final_cost, static_cast<int>(summary.iterations.size()), summary.IsSolutionUsable()};
}

}  // namespace ldp
