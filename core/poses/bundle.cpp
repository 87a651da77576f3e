#include "bundle.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "reprojection.h"

namespace ldp {
namespace {

constexpr double kDistortionSigma = 0.1;  // of k1 and k2 about zero
constexpr size_t kParts = 8;              // into which points are dealt out whatever the number of threads
constexpr double kFirstRadius = 1e4, kLargestRadius = 1e16, kSmallestRadius = 1e-12;  // of trust, inverse damping
constexpr double kLeastQuality = 1e-3;   // of a step: what it lowers the cost by, against what it promised
constexpr double kLeastDiagonal = 1e-6;  // of the normal matrix scaled to unit columns, for damping
constexpr int kLongestStride = 4;        // times a step's length that is tried

double robust(double squared, double loss_squared) { return 0.5 * loss_squared * std::log1p(squared / loss_squared); }

// Levenberg and Marquardt's addition to a diagonal element of the normal matrix.
double damping(double diagonal, double radius) {
  const double scale = 1 + std::sqrt(diagonal);
  return std::max(diagonal, kLeastDiagonal * scale * scale) / radius;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  return angle < 1e-300 ? Eigen::Matrix3d::Identity() : Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

// Everything that is adjusted.
struct State {
  std::vector<FreeCamera> cameras;
  Eigen::Vector3d lens = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points;
};

// What elimination leaves of a point: V = L L^T is its damped normal matrix, g its gradient.
struct Eliminated {
  Eigen::Matrix3d inverse_l;
  Eigen::Vector3d gradient, solved;  // solved = L^-1 g
  Eigen::Vector3d damping;
  Eigen::Matrix<double, kLensSize, kPointSize> lens;  // its coupling with the lens, times L^-T
};

// A share of the points and what they add to the system of cameras and lens (lower triangle).
struct Part {
  size_t begin = 0, end = 0;
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient, reduced;  // reduced: what elimination adds to the right side
  Eigen::VectorXd diagonal;           // of the normal matrix before elimination
  double sum = 0;
};

// Levenberg-Marquardt with iteratively reweighted least squares; points are eliminated one by one (Schur complement),
// which leaves a dense system of cameras and lens (Triggs et al. 1999, "Bundle adjustment - a modern synthesis").
template <Model kModel>
class Adjuster {
  static constexpr int kCamera = camera_size(kModel);
  using CameraByPoint = Eigen::Matrix<double, kCamera, kPointSize>;

 public:
  Adjuster(const Bundle& bundle, const BundleOptions& options, const Job& job)
      : options_(options), job_(job), loss_squared_(options.loss_px * options.loss_px) {
    sort_observations(bundle);
    number_cameras(bundle);
    for (const Pose& pose : bundle.cameras) {
      state_.cameras.push_back({pose.world_from_camera.transpose(), pose.centre});
    }
    state_.lens = {std::log(bundle.lens.focal_px), bundle.lens.k1, bundle.lens.k2};
    for (const InversePoint& point : bundle.points) {
      const Eigen::Vector3d e1 = point.direction.unitOrthogonal();
      frames_.push_back({point.direction, e1, point.direction.cross(e1)});
      state_.points.emplace_back(0, 0, kModel == Model::rotation ? 0 : point.inverse_distance);
    }
    prior_ = options.focal_prior.value_or(FocalPrior{bundle.lens.focal_px, 1e6});
    const bool distortion = options.refine_distortion;
    free_lens_ = {options.refine_focal ? 1.0 : 0.0, distortion ? 1.0 : 0.0, distortion ? 1.0 : 0.0};
  }

  BundleSummary run() {
    BundleSummary summary;
    double cost = cost_of(state_), radius = kFirstRadius, shrink = 2;
    while (summary.iterations < options_.most_iterations && radius > kSmallestRadius) {
      job_.check();
      ++summary.iterations;
      const double promised = solve(radius);
      if (promised >= 0 && promised <= 0.1 * options_.settled * cost) break;
      State next = moved(1);
      double value = promised > 0 ? cost_of(next) : cost;
      const double quality = (cost - value) / promised;
      if (!(promised > 0) || !(quality > kLeastQuality)) {
        radius /= shrink, shrink *= 2;
        continue;
      }
      stride(next, value);
      const bool settled = cost - value <= options_.settled * cost;
      state_ = std::move(next), cost = value;
      radius = std::min(kLargestRadius, radius / std::max(1.0 / 3, 1 - std::pow(2 * quality - 1, 3)));
      shrink = 2;
      if (settled) break;
    }
    summary.cost = cost;
    summary.usable = std::isfinite(cost);
    return summary;
  }

  void take(Bundle& bundle) const {
    for (size_t i = 0; i < bundle.cameras.size(); ++i) {
      Pose& pose = bundle.cameras[i];
      const Eigen::Quaterniond q(state_.cameras[i].rotation);
      pose.world_from_camera = q.normalized().toRotationMatrix().transpose();
      pose.centre = kModel == Model::free ? state_.cameras[i].centre : Eigen::Vector3d(pose.world_from_camera.col(2));
    }
    for (size_t i = 0; i < bundle.points.size(); ++i) {
      const Eigen::Vector3d& p = state_.points[i];
      const Eigen::Vector3d m = frames_[i].base + p[0] * frames_[i].e1 + p[1] * frames_[i].e2;
      bundle.points[i] = {m.normalized(), kModel == Model::rotation ? 0 : p[2] / m.norm()};
    }
    bundle.lens = {std::exp(state_.lens[0]), state_.lens[1], state_.lens[2]};
  }

 private:
  // By point, and by camera within a point.
  void sort_observations(const Bundle& bundle) {
    first_.assign(bundle.points.size() + 1, 0);
    for (const BundleObservation& o : bundle.observations) ++first_[static_cast<size_t>(o.point) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    observations_ = bundle.observations;
    std::stable_sort(observations_.begin(), observations_.end(),
                     [](const BundleObservation& a, const BundleObservation& b) {
                       return a.point != b.point ? a.point < b.point : a.camera < b.camera;
                     });
    couplings_.resize(observations_.size());
    eliminated_.resize(bundle.points.size());
    point_steps_.resize(bundle.points.size());
    parts_.resize(kParts);
    size_t point = 0;
    for (size_t i = 0; i < kParts; ++i) {
      parts_[i].begin = point;
      while (point < bundle.points.size() && first_[point] * kParts < observations_.size() * (i + 1)) ++point;
      parts_[i].end = i + 1 == kParts ? bundle.points.size() : point;
    }
  }

  // Only cameras that see something take part.
  void number_cameras(const Bundle& bundle) {
    place_.assign(bundle.cameras.size(), -1);
    for (const BundleObservation& o : observations_) place_[static_cast<size_t>(o.camera)] = 0;
    int next = 0;
    for (Eigen::Index& place : place_) {
      if (place == 0) place = kCamera * next++;
    }
    lens_ = kCamera * next;
    size_ = lens_ + kLensSize;
  }

  Eigen::Index place(const BundleObservation& o) const { return place_[static_cast<size_t>(o.camera)]; }

  template <typename Body>
  void for_parts(const Body& body) {
    parallel_for(job_, static_cast<int>(kParts), [&](int i) { body(parts_[static_cast<size_t>(i)]); });
  }

  double sum_of_parts() const {
    return std::accumulate(parts_.begin(), parts_.end(), 0.0, [](double sum, const Part& p) { return sum + p.sum; });
  }

  double cost_of(const State& state) {
    for_parts([&](Part& part) {
      part.sum = 0;
      for (size_t point = part.begin; point < part.end; ++point) {
        for (size_t i = first_[point]; i < first_[point + 1]; ++i) {
          const BundleObservation& o = observations_[i];
          const Seen seen = see<kModel>(state.cameras[static_cast<size_t>(o.camera)], state.lens, frames_[point],
                                        state.points[point]);
          const double squared =
              seen.in_front ? residual(seen, state.lens, o).squaredNorm() : 2 * kBehind_px * kBehind_px;
          part.sum += robust(squared, loss_squared_);
        }
      }
    });
    return sum_of_parts() + prior_cost(state);
  }

  double prior_cost(const State& state) const {
    double squares = lens_prior(state.lens).squaredNorm();
    for (size_t i = 0; kModel == Model::free && i < place_.size(); ++i) {
      if (place_[i] >= 0) squares += arc_prior(state.cameras[i]).squaredNorm();
    }
    return 0.5 * squares;
  }

  // A centre's place in its own camera is e_z, give or take sigma.
  Eigen::Vector3d arc_prior(const FreeCamera& camera) const {
    return (camera.rotation * camera.centre - Eigen::Vector3d::UnitZ()) / options_.arc_sigma;
  }

  Eigen::Vector3d lens_weights() const { return {1 / prior_.log_sigma, 1 / kDistortionSigma, 1 / kDistortionSigma}; }
  Eigen::Vector3d lens_prior(const Eigen::Vector3d& lens) const {
    return (lens - Eigen::Vector3d(std::log(prior_.focal_px), 0, 0))
        .cwiseProduct(lens_weights())
        .cwiseProduct(free_lens_);
  }

  // Normal equations at the present state, points eliminated.
  void eliminate(Part& part, double radius) {
    part.normal.setZero(size_, size_);
    part.gradient.setZero(size_);
    part.reduced.setZero(size_);
    part.diagonal.setZero(size_);
    for (size_t point = part.begin; point < part.end; ++point) {
      Eigen::Matrix3d v = Eigen::Matrix3d::Zero(), with_lens = v;
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (size_t i = first_[point]; i < first_[point + 1]; ++i) add_observation(part, i, v, with_lens, g);
      eliminate_point(part, point, v, with_lens, g, radius);
    }
  }

  void add_observation(Part& part, size_t i, Eigen::Matrix3d& v, Eigen::Matrix3d& with_lens, Eigen::Vector3d& g) {
    const BundleObservation& o = observations_[i];
    const size_t point = static_cast<size_t>(o.point);
    const FreeCamera& camera = state_.cameras[static_cast<size_t>(o.camera)];
    const Seen seen = see<kModel>(camera, state_.lens, frames_[point], state_.points[point]);
    couplings_[i].setZero();
    if (!seen.in_front) return;
    const Eigen::Vector2d r = residual(seen, state_.lens, o);
    const double weight = 1 / (1 + r.squaredNorm() / loss_squared_);
    Derivatives<kModel> by =
        derivatives<kModel>(camera, state_.lens, frames_[point], state_.points[point], seen, o.weight);
    for (int k = 0; k < kLensSize; ++k) by.by_lens.col(k) *= free_lens_[k];
    const Eigen::Matrix<double, kCamera, 2> camera_t = weight * by.by_camera.transpose();
    const Eigen::Matrix<double, kLensSize, 2> lens_t = weight * by.by_lens.transpose();
    const Eigen::Index c = place(o);
    part.normal.block<kCamera, kCamera>(c, c).noalias() += camera_t * by.by_camera;
    part.normal.block<kLensSize, kCamera>(lens_, c).noalias() += lens_t * by.by_camera;
    part.normal.block<kLensSize, kLensSize>(lens_, lens_).noalias() += lens_t * by.by_lens;
    part.diagonal.segment<kCamera>(c) += weight * by.by_camera.colwise().squaredNorm().transpose();
    part.diagonal.segment<kLensSize>(lens_) += weight * by.by_lens.colwise().squaredNorm().transpose();
    part.gradient.segment<kCamera>(c).noalias() += camera_t * r;
    part.gradient.segment<kLensSize>(lens_).noalias() += lens_t * r;
    couplings_[i].noalias() = camera_t * by.by_point;
    with_lens.noalias() += lens_t * by.by_point;
    v.noalias() += weight * by.by_point.transpose() * by.by_point;
    g.noalias() += weight * by.by_point.transpose() * r;
  }

  void eliminate_point(Part& part, size_t point, Eigen::Matrix3d v, const Eigen::Matrix3d& with_lens,
                       const Eigen::Vector3d& g, double radius) {
    Eliminated& e = eliminated_[point];
    for (int k = 0; k < kPointSize; ++k) e.damping[k] = damping(v(k, k), radius);
    v.diagonal() += e.damping;
    const Eigen::Matrix3d l = v.llt().matrixL();
    e.inverse_l = l.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
    e.gradient = g;
    e.solved = e.inverse_l * g;
    e.lens = with_lens * e.inverse_l.transpose();
    for (size_t i = first_[point]; i < first_[point + 1]; ++i) {
      couplings_[i] = (couplings_[i] * e.inverse_l.transpose()).eval();
      const Eigen::Index row = place(observations_[i]);
      for (size_t j = first_[point]; j <= i; ++j) {
        const Eigen::Index column = place(observations_[j]);
        part.normal.block<kCamera, kCamera>(row, column).noalias() -= couplings_[i] * couplings_[j].transpose();
      }
      part.normal.block<kLensSize, kCamera>(lens_, row).noalias() -= e.lens * couplings_[i].transpose();
      part.reduced.segment<kCamera>(row).noalias() += couplings_[i] * e.solved;
    }
    part.normal.block<kLensSize, kLensSize>(lens_, lens_).noalias() -= e.lens * e.lens.transpose();
    part.reduced.segment<kLensSize>(lens_).noalias() += e.lens * e.solved;
  }

  // The step that the equations promise, and by how much they promise it to lower the cost; negative when they cannot
  // be solved.
  double solve(double radius) {
    for_parts([&](Part& part) { eliminate(part, radius); });
    Part& all = parts_.front();
    for (size_t i = 1; i < kParts; ++i) {
      all.normal += parts_[i].normal;
      all.gradient += parts_[i].gradient;
      all.reduced += parts_[i].reduced;
      all.diagonal += parts_[i].diagonal;
    }
    add_priors(all);
    Eigen::VectorXd damp(size_);
    for (Eigen::Index i = 0; i < size_; ++i) damp[i] = damping(all.diagonal[i], radius);
    all.normal.diagonal() += damp;
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(all.normal);
    if (factors.info() != Eigen::Success) return -1;
    step_ = factors.solve(all.reduced - all.gradient);
    if (!step_.allFinite()) return -1;
    const double of_cameras = 0.5 * step_.dot(damp.cwiseProduct(step_) - all.gradient);
    for_parts([&](Part& part) { part.sum = substitute(part); });
    return of_cameras + sum_of_parts();
  }

  void add_priors(Part& all) const {
    const Eigen::Vector3d weights = lens_weights().cwiseProduct(free_lens_), squares = weights.cwiseAbs2();
    all.normal.diagonal().tail<kLensSize>() += squares;
    all.diagonal.tail<kLensSize>() += squares;
    all.gradient.tail<kLensSize>() += weights.cwiseProduct(lens_prior(state_.lens));
    for (size_t i = 0; kModel == Model::free && i < place_.size(); ++i) {
      if (place_[i] < 0) continue;
      const FreeCamera& camera = state_.cameras[i];
      Eigen::Matrix<double, 3, 6> by;
      by << -cross_matrix(camera.rotation * camera.centre), camera.rotation;
      by /= options_.arc_sigma;
      all.normal.block<6, 6>(place_[i], place_[i]) += by.transpose() * by;
      all.diagonal.segment<6>(place_[i]) += by.colwise().squaredNorm().transpose();
      all.gradient.segment<6>(place_[i]) += by.transpose() * arc_prior(camera);
    }
  }

  // Steps of points from those of cameras and lens; what they promise.
  double substitute(const Part& part) {
    double promised = 0;
    for (size_t point = part.begin; point < part.end; ++point) {
      const Eliminated& e = eliminated_[point];
      Eigen::Vector3d right = e.solved + e.lens.transpose() * step_.tail<kLensSize>();
      for (size_t i = first_[point]; i < first_[point + 1]; ++i) {
        right += couplings_[i].transpose() * step_.segment<kCamera>(place(observations_[i]));
      }
      const Eigen::Vector3d step = -e.inverse_l.transpose() * right;
      point_steps_[point] = step;
      promised += 0.5 * step.dot(e.damping.cwiseProduct(step) - e.gradient);
    }
    return promised;
  }

  // The present state moved by so many times the step.
  State moved(double times) const {
    State next = state_;
    for (size_t i = 0; i < place_.size(); ++i) {
      if (place_[i] < 0) continue;
      const Eigen::Matrix<double, kCamera, 1> step = times * step_.segment<kCamera>(place_[i]);
      next.cameras[i].rotation = rotation(step.template head<3>()) * next.cameras[i].rotation;
      if constexpr (kModel == Model::free) next.cameras[i].centre += step.template tail<3>();
    }
    next.lens += times * step_.tail<kLensSize>();
    for (size_t i = 0; i < next.points.size(); ++i) next.points[i] += times * point_steps_[i];
    return next;
  }

  // Weights that lag behind make steps too short: longer ones are taken as long as they lower the cost.
  void stride(State& next, double& value) {
    for (double times = 2; times <= kLongestStride; times *= 2) {
      State farther = moved(times);
      const double cost = cost_of(farther);
      if (!(cost < value)) return;
      next = std::move(farther), value = cost;
    }
  }

  const BundleOptions& options_;
  const Job& job_;
  double loss_squared_;
  FocalPrior prior_;
  Eigen::Vector3d free_lens_;
  State state_;
  std::vector<DirectionFrame> frames_;
  std::vector<BundleObservation> observations_;
  std::vector<size_t> first_;             // observation of each point, and their number
  std::vector<Eigen::Index> place_;       // of a camera in the system; -1: it sees nothing
  Eigen::Index lens_ = 0, size_ = 0;      // place of the lens, and the system's size
  std::vector<CameraByPoint> couplings_;  // by observation
  std::vector<Eliminated> eliminated_;    // by point
  std::vector<Part> parts_;
  Eigen::VectorXd step_;  // of cameras and lens
  std::vector<Eigen::Vector3d> point_steps_;
};

template <Model kModel>
BundleSummary adjust_model(Bundle& bundle, const BundleOptions& options, const Job& job) {
  Adjuster<kModel> adjuster(bundle, options, job);
  const BundleSummary summary = adjuster.run();
  adjuster.take(bundle);
  return summary;
}

}  // namespace

BundleSummary adjust(Bundle& bundle, const BundleOptions& options, const Job& job) {
  job.check();
  if (bundle.observations.empty()) return {};
  switch (options.model) {
    case Model::rotation:
      return adjust_model<Model::rotation>(bundle, options, job);
    case Model::spherical:
      return adjust_model<Model::spherical>(bundle, options, job);
    case Model::free:
      break;
  }
  return adjust_model<Model::free>(bundle, options, job);
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
