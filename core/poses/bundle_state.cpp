#include "bundle_state.h"

#include <algorithm>
#include <cmath>

namespace ldp {
namespace {

constexpr double kDistortionSigma = 0.1;  // of k1 and k2 about zero
constexpr double kHeldSigma = 1e-8;       // of what is held where it is

}  // namespace

LensPrior lens_prior(const Bundle& bundle, const BundleOptions& options) {
  const FocalPrior prior = options.focal_prior.value_or(FocalPrior{bundle.lens.focal_px, 1e6});
  const double bend = options.refine_distortion ? kDistortionSigma : kHeldSigma;
  return {{std::log(options.refine_focal ? prior.focal_px : bundle.lens.focal_px),
           options.refine_distortion ? 0 : bundle.lens.k1, options.refine_distortion ? 0 : bundle.lens.k2},
          {options.refine_focal ? prior.log_sigma : kHeldSigma, bend, bend}};
}

State state_of(const Bundle& bundle, const BundleOptions& options) {
  State state;
  for (const Pose& pose : bundle.cameras) {
    state.turns.emplace_back(Eigen::Matrix3d(pose.world_from_camera.transpose()));
    state.cameras.push_back({state.turns.back().toRotationMatrix(), pose.centre});
  }
  state.lens = {std::log(bundle.lens.focal_px), bundle.lens.k1, bundle.lens.k2, bundle.lens.focal_px};
  state.points = bundle.points;
  for (InversePoint& point : state.points) {
    if (options.in_front) point.inverse_distance = std::max(point.inverse_distance, 0.0);
  }
  return state;
}

void take(const State& state, const BundleOptions& options, Bundle& bundle) {
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    Pose& pose = bundle.cameras[i];
    pose.world_from_camera = state.cameras[i].camera_from_world.transpose();
    pose.centre =
        options.model == Model::free ? state.cameras[i].centre : Eigen::Vector3d(pose.world_from_camera.col(2));
  }
  bundle.points = state.points;
  if (options.model == Model::rotation) {
    for (InversePoint& point : bundle.points) point.inverse_distance = 0;
  }
  if (options.refine_focal) bundle.lens.focal_px = state.lens.focal_px;
  if (options.refine_distortion) bundle.lens.k1 = state.lens.k1, bundle.lens.k2 = state.lens.k2;
}

}  // namespace ldp
