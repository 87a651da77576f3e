// What bundle adjustment changes, in the form in which it does, and what it believes of the lens.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "bundle.h"
#include "reprojection.h"

namespace ldp {

// Mean and deviation of the lens's parameters. What is not refined is held by a narrow one.
struct LensPrior {
  Eigen::Vector3d mean, sigma;
};

LensPrior lens_prior(const Bundle& bundle, const BundleOptions& options);

// All that is adjusted.
struct State {
  std::vector<Eigen::Quaterniond> turns;  // camera from world
  std::vector<CameraState> cameras;
  LensState lens;
  std::vector<InversePoint> points;
};

State state_of(const Bundle& bundle, const BundleOptions& options);

// What of it the options let change.
void take(const State& state, const BundleOptions& options, Bundle& bundle);

}  // namespace ldp
