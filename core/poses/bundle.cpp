#include "bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "bundle_state.h"
#include "reprojection.h"

namespace ldp {
namespace {

constexpr double kLongestLog = 14;      // of a focal length in pixels: beyond, a step went astray
constexpr double kBehind_px = 1e3;      // residual of a point behind the camera
constexpr int kShares = 8;              // of the points, each added up by one thread
constexpr int kLens = 3;                // its parameters: log focal, k1, k2
constexpr double kFirstRadius = 1e4;    // of the region in which steps are trusted
constexpr double kLeastRadius = 1e-20;  // below, no step helps
constexpr double kLeastGain = 1e-3;     // of what a step promised, to be taken
constexpr double kLeastDamped = 1e-6;   // diagonal of the scaled normal matrix that is damped at least

// Cauchy's loss of a squared residual: b log(1 + s / b), and its derivative.
struct Loss {
  double scale_squared = 1;
  double cost(double squared) const { return scale_squared * std::log1p(squared / scale_squared); }
  double slope(double squared) const { return 1 / (1 + squared / scale_squared); }
};

// Damping of a parameter as a share of what holds it, but for what hardly anything holds: in terms of the parameter
// scaled by 1 / (1 + root of its diagonal).
double damped(double diagonal) {
  const double scale = 1 + std::sqrt(diagonal);
  return std::max(diagonal, kLeastDamped * scale * scale);
}

template <Model kModel>
class Adjustment {
 public:
  Adjustment(Bundle& bundle, const BundleOptions& options, const Job& job)
      : bundle_(bundle),
        options_(options),
        job_(job),
        prior_(lens_prior(bundle, options)),
        state_(state_of(bundle, options)),
        size_(kCamera * static_cast<Eigen::Index>(bundle.cameras.size()) + kLens) {
    sort_observations();
    hold_the_world();
  }

  BundleSummary run() {
    double cost = cost_of(state_), radius = kFirstRadius, shrink = 2;
    int iterations = 1;
    for (; iterations <= options_.most_iterations && radius > kLeastRadius; ++iterations) {
      job_.check();
      const System system = linearise(1 / radius);
      const Eigen::VectorXd change = step(system);
      State tried = state_;
      const double promised = move(change, tried) + promise(change, system, 1 / radius);
      const double after = cost_of(tried), gain = cost - after;
      const bool settled = std::abs(gain) <= options_.settled * cost;
      if (std::isfinite(after) && gain > (settled ? 0 : kLeastGain * promised)) {
        state_ = std::move(tried);
        cost = after;
        radius = std::min(1e16, radius / std::max(1.0 / 3, 1 - std::pow(2 * gain / promised - 1, 3)));
        shrink = 2;
      } else {
        radius /= shrink;
        shrink *= 2;
      }
      if (settled) break;
    }
    take(state_, options_, bundle_);
    return {cost, iterations, std::isfinite(cost)};
  }

 private:
  using Residual = Reprojection<kModel>;
  static constexpr int kCamera = Residual::kCamera, kPoint = Residual::kPoint;
  using CameraByPoint = Eigen::Matrix<double, kCamera, kPoint>;
  using PointVector = Eigen::Matrix<double, kPoint, 1>;
  using PointMatrix = Eigen::Matrix<double, kPoint, kPoint>;

  // Normal equations of cameras and lens, the lens last. Of the matrix, the lower triangle.
  struct System {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd gradient;                  // reduced by what the points take
    Eigen::VectorXd diagonal, whole_gradient;  // before the points were eliminated
  };

  // What is left of a point to find its step from those of the cameras.
  struct Eliminated {
    PointMatrix inverse;
    PointVector gradient, damping;
    Eigen::Matrix<double, kLens, kPoint> by_lens;
    Eigen::Vector3d e1, e2;
  };

  // Observations point by point.
  void sort_observations() {
    const size_t points = bundle_.points.size();
    first_.assign(points + 1, 0);
    for (const BundleObservation& o : bundle_.observations) ++first_[static_cast<size_t>(o.point) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<size_t> next(first_.begin(), first_.end() - 1);
    seen_.resize(bundle_.observations.size());
    for (const BundleObservation& o : bundle_.observations) seen_[next[static_cast<size_t>(o.point)]++] = o;
    observed_.assign(bundle_.cameras.size(), false);
    for (const BundleObservation& o : seen_) observed_[static_cast<size_t>(o.camera)] = true;
    camera_by_point_.resize(seen_.size());
    eliminated_.resize(points);
  }

  // Turning the world changes no residual: without one camera held, rounding errors alone would say how it turns, and
  // cameras would come out otherwise on every machine.
  void hold_the_world() {
    const size_t cameras = bundle_.cameras.size();
    for (size_t i = 0; i < cameras && held_ < 0; ++i) {
      const size_t camera = (i + cameras / 2) % cameras;
      if (observed_[camera]) held_ = static_cast<int>(camera);
    }
  }

  // Points first .. last of a share.
  std::pair<size_t, size_t> share(int i) const {
    const size_t points = bundle_.points.size();
    return {points * static_cast<size_t>(i) / kShares, points * static_cast<size_t>(i + 1) / kShares};
  }
  double pair_scale(size_t point) const { return first_[point + 1] - first_[point] > 2 ? 1 : options_.pair_weight; }
  const CameraState& camera(const State& state, const BundleObservation& o) const {
    return state.cameras[static_cast<size_t>(o.camera)];
  }
  Loss loss() const { return {options_.loss_px * options_.loss_px}; }

  double cost_of(const State& state) const {
    std::array<double, kShares> costs{};
    if (!(std::abs(state.lens.log_focal) < kLongestLog)) return std::numeric_limits<double>::infinity();
    parallel_for(job_, kShares, [&](int i) {
      const auto [begin, end] = share(i);
      double sum = 0;
      Residual r;
      for (size_t p = begin; p < end; ++p) {
        for (size_t o = first_[p]; o < first_[p + 1]; ++o) {
          const bool before = r.evaluate(camera(state, seen_[o]), state.lens, state.points[p], seen_[o]);
          sum += pair_scale(p) * loss().cost(before ? r.residual.squaredNorm() : 2 * kBehind_px * kBehind_px);
        }
      }
      costs[static_cast<size_t>(i)] = sum;
    });
    double sum = std::accumulate(costs.begin(), costs.end(), 0.0) + lens_residual(state).squaredNorm();
    for (size_t c = 0; kModel == Model::free && c < state.cameras.size(); ++c) {
      if (observed_[c]) sum += arc_residual(state.cameras[c]).squaredNorm();
    }
    return 0.5 * sum;
  }

  Eigen::Vector3d lens_residual(const State& state) const {
    const Eigen::Vector3d lens(state.lens.log_focal, state.lens.k1, state.lens.k2);
    return (lens - prior_.mean).cwiseQuotient(prior_.sigma);
  }
  // A centre's place in its own camera is e_z, give or take sigma.
  Eigen::Vector3d arc_residual(const CameraState& camera) const {
    return (camera.camera_from_world * camera.centre - Eigen::Vector3d::UnitZ()) / options_.arc_sigma;
  }

  System empty() const {
    return {Eigen::MatrixXd::Zero(size_, size_), Eigen::VectorXd::Zero(size_), Eigen::VectorXd::Zero(size_),
            Eigen::VectorXd::Zero(size_)};
  }

  System linearise(double damping) {
    std::array<System, kShares> parts;
    parallel_for(job_, kShares, [&](int i) {
      System& part = parts[static_cast<size_t>(i)] = empty();
      const auto [begin, end] = share(i);
      for (size_t p = begin; p < end; ++p) add_point(p, damping, part);
    });
    System system = std::move(parts[0]);
    for (size_t i = 1; i < kShares; ++i) {
      system.matrix += parts[i].matrix;
      system.gradient += parts[i].gradient;
      system.diagonal += parts[i].diagonal;
      system.whole_gradient += parts[i].whole_gradient;
    }
    add_priors(system);
    for (Eigen::Index i = 0; i < size_; ++i) system.matrix(i, i) += damping * damped(system.diagonal[i]);
    hold(system);
    return system;
  }

  // What a point adds once it is eliminated.
  void add_point(size_t p, double damping, System& system) {
    Eliminated& rest = eliminated_[p];
    const InversePoint& point = state_.points[p];
    rest.e1 = point.direction.unitOrthogonal();
    rest.e2 = point.direction.cross(rest.e1);
    rest.gradient.setZero();
    rest.by_lens.setZero();
    PointMatrix normal = PointMatrix::Zero();
    const PointState here{point, rest.e1, rest.e2};
    const Eigen::Index lens = size_ - kLens;
    for (size_t o = first_[p]; o < first_[p + 1]; ++o) {
      const BundleObservation& seen = seen_[o];
      Residual r;
      camera_by_point_[o].setZero();
      if (!r.evaluate(camera(state_, seen), state_.lens, point, seen)) continue;
      r.differentiate(camera(state_, seen), state_.lens, here, seen.weight);
      r.scale(std::sqrt(pair_scale(p) * loss().slope(r.residual.squaredNorm())));
      const Eigen::Index at = kCamera * seen.camera;
      const Eigen::Matrix<double, kCamera, kCamera> square = r.by_camera.transpose() * r.by_camera;
      const Eigen::Matrix<double, kLens, kLens> lens_square = r.by_lens.transpose() * r.by_lens;
      const Eigen::Matrix<double, kCamera, 1> gradient = r.by_camera.transpose() * r.residual;
      const Eigen::Matrix<double, kLens, 1> lens_gradient = r.by_lens.transpose() * r.residual;
      system.matrix.template block<kCamera, kCamera>(at, at) += square;
      system.matrix.template block<kLens, kCamera>(lens, at) += r.by_lens.transpose() * r.by_camera;
      system.matrix.template block<kLens, kLens>(lens, lens) += lens_square;
      system.whole_gradient.template segment<kCamera>(at) += gradient;
      system.whole_gradient.template segment<kLens>(lens) += lens_gradient;
      system.diagonal.template segment<kCamera>(at) += square.diagonal();
      system.diagonal.template segment<kLens>(lens) += lens_square.diagonal();
      camera_by_point_[o] = r.by_camera.transpose() * r.by_point;
      rest.by_lens += r.by_lens.transpose() * r.by_point;
      rest.gradient += r.by_point.transpose() * r.residual;
      normal += r.by_point.transpose() * r.by_point;
    }
    if constexpr (kPoint == 3) {
      if (options_.in_front && point.inverse_distance <= 0 && rest.gradient[2] > 0) stay_at_infinity(p, normal);
    }
    for (int i = 0; i < kPoint; ++i) {
      rest.damping[i] = damping * damped(normal(i, i));
      normal(i, i) += rest.damping[i];
    }
    rest.inverse = normal.inverse();
    eliminate(p, system);
  }

  void stay_at_infinity(size_t p, PointMatrix& normal) {
    normal.row(2).setZero();
    normal.col(2).setZero();
    normal(2, 2) = 1;
    eliminated_[p].gradient[2] = 0;
    eliminated_[p].by_lens.col(2).setZero();
    for (size_t o = first_[p]; o < first_[p + 1]; ++o) camera_by_point_[o].col(2).setZero();
  }

  void eliminate(size_t p, System& system) const {
    const Eliminated& rest = eliminated_[p];
    const Eigen::Index lens = size_ - kLens;
    const Eigen::Matrix<double, kLens, kPoint> lens_inverse = rest.by_lens * rest.inverse;
    system.matrix.template block<kLens, kLens>(lens, lens) -= lens_inverse * rest.by_lens.transpose();
    system.gradient.template segment<kLens>(lens) -= lens_inverse * rest.gradient;
    for (size_t o = first_[p]; o < first_[p + 1]; ++o) {
      const Eigen::Index at = kCamera * seen_[o].camera;
      const CameraByPoint inverse = camera_by_point_[o] * rest.inverse;
      system.gradient.template segment<kCamera>(at) -= inverse * rest.gradient;
      system.matrix.template block<kLens, kCamera>(lens, at) -= lens_inverse * camera_by_point_[o].transpose();
      for (size_t q = first_[p]; q < first_[p + 1]; ++q) {
        if (seen_[q].camera > seen_[o].camera) continue;
        system.matrix.template block<kCamera, kCamera>(at, kCamera * seen_[q].camera) -=
            inverse * camera_by_point_[q].transpose();
      }
    }
  }

  void add_priors(System& system) const {
    const Eigen::Index lens = size_ - kLens;
    const Eigen::Vector3d tight = prior_.sigma.cwiseAbs2().cwiseInverse();
    system.matrix.diagonal().template segment<kLens>(lens) += tight;
    system.diagonal.template segment<kLens>(lens) += tight;
    system.whole_gradient.template segment<kLens>(lens) += lens_residual(state_).cwiseQuotient(prior_.sigma);
    if constexpr (kModel == Model::free) {
      for (size_t c = 0; c < state_.cameras.size(); ++c) {
        if (!observed_[c]) continue;
        const CameraState& camera = state_.cameras[c];
        Eigen::Matrix<double, 3, 6> by;
        by << -cross_matrix(camera.camera_from_world * camera.centre), camera.camera_from_world;
        by /= options_.arc_sigma;
        const Eigen::Index at = kCamera * static_cast<Eigen::Index>(c);
        const Eigen::Matrix<double, 6, 6> square = by.transpose() * by;
        system.matrix.template block<6, 6>(at, at) += square;
        system.diagonal.template segment<6>(at) += square.diagonal();
        system.whole_gradient.template segment<6>(at) += by.transpose() * arc_residual(camera);
      }
    }
    system.gradient += system.whole_gradient;
  }

  void hold(System& system) const {
    const auto hold_one = [&](Eigen::Index i) {
      system.matrix.row(i).setZero();
      system.matrix.col(i).setZero();
      system.matrix(i, i) = 1;
      system.gradient[i] = 0;
    };
    for (size_t c = 0; c < observed_.size(); ++c) {
      const int held = !observed_[c] ? kCamera : static_cast<int>(c) == held_ ? 3 : 0;
      for (int i = 0; i < held; ++i) hold_one(kCamera * static_cast<Eigen::Index>(c) + i);
    }
  }

  static Eigen::VectorXd step(const System& system) {
    return -system.matrix.template selfadjointView<Eigen::Lower>().ldlt().solve(system.gradient);
  }

  // By how much the cost should fall by a step of cameras and lens if it were as the normal equations have it.
  double promise(const Eigen::VectorXd& change, const System& system, double damping) const {
    double sum = 0;
    for (Eigen::Index i = 0; i < size_; ++i)
      sum += change[i] * (damping * damped(system.diagonal[i]) * change[i] - system.whole_gradient[i]);
    return 0.5 * sum;
  }

  // Gives what the step of the points promises.
  double move(const Eigen::VectorXd& change, State& tried) const {
    const Eigen::Index lens = size_ - kLens;
    for (size_t c = 0; c < tried.cameras.size(); ++c) {
      const Eigen::Index at = kCamera * static_cast<Eigen::Index>(c);
      const Eigen::Vector3d turn = change.template segment<3>(at);
      if (turn.norm() > 0) {
        const Eigen::Quaterniond q(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
        tried.turns[c] = (q * tried.turns[c]).normalized();
      }
      tried.cameras[c].camera_from_world = tried.turns[c].toRotationMatrix();
      if constexpr (kModel == Model::free) tried.cameras[c].centre += change.template segment<3>(at + 3);
    }
    tried.lens.log_focal += change[lens];
    tried.lens.k1 += change[lens + 1], tried.lens.k2 += change[lens + 2];
    tried.lens.focal_px = std::exp(std::min(tried.lens.log_focal, kLongestLog));
    std::array<double, kShares> promises{};
    parallel_for(job_, kShares, [&](int i) {
      const auto [begin, end] = share(i);
      for (size_t p = begin; p < end; ++p) promises[static_cast<size_t>(i)] += move_point(p, change, tried.points[p]);
    });
    return 0.5 * std::accumulate(promises.begin(), promises.end(), 0.0);
  }

  double move_point(size_t p, const Eigen::VectorXd& change, InversePoint& point) const {
    const Eliminated& rest = eliminated_[p];
    PointVector left = rest.gradient + rest.by_lens.transpose() * change.template tail<kLens>();
    for (size_t o = first_[p]; o < first_[p + 1]; ++o)
      left += camera_by_point_[o].transpose() * change.template segment<kCamera>(kCamera * seen_[o].camera);
    const PointVector moved = -rest.inverse * left;
    const Eigen::Vector3d m = point.direction + moved[0] * rest.e1 + moved[1] * rest.e2;
    double w = kPoint == 3 ? point.inverse_distance + moved[kPoint - 1] : 0;
    if (options_.in_front) w = std::max(w, 0.0);
    point = {m.normalized(), w / m.norm()};
    return moved.dot(rest.damping.cwiseProduct(moved) - rest.gradient);
  }

  Bundle& bundle_;
  const BundleOptions& options_;
  const Job& job_;
  LensPrior prior_;
  State state_;
  Eigen::Index size_;
  std::vector<BundleObservation> seen_;
  std::vector<size_t> first_;  // of a point's observations in seen_, and one more
  std::vector<bool> observed_;
  int held_ = -1;                               // the camera whose rotation is
  std::vector<CameraByPoint> camera_by_point_;  // of the observations
  std::vector<Eliminated> eliminated_;
};

}  // namespace

BundleSummary adjust(Bundle& bundle, const BundleOptions& options, const Job& job) {
  job.check();
  if (bundle.observations.empty()) return {};
  switch (options.model) {
    case Model::rotation:
      return Adjustment<Model::rotation>(bundle, options, job).run();
    case Model::spherical:
      return Adjustment<Model::spherical>(bundle, options, job).run();
    case Model::free:
      break;
  }
  return Adjustment<Model::free>(bundle, options, job).run();
}

Eigen::Vector2d ray_of(const Eigen::Vector2d& position_px, const Lens& lens) {
  const Intrinsics k{0, 0, lens.focal_px, lens.focal_px, 0, 0, lens.k1, lens.k2, 0, 0};
  return unproject(k, position_px).head<2>();
}

Projection project_point(const Pose& camera, const Lens& lens, const InversePoint& point) {
  const Eigen::Vector3d p = camera.world_from_camera.transpose() * point.seen_from(camera.centre);
  if (p.z() < kBeforeCamera) return {};
  return {lens.focal_px * distort(p.head<2>() / p.z(), lens.k1, lens.k2).position, true};
}

}  // namespace ldp
