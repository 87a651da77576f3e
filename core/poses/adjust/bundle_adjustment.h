// Bundle adjustment (Ceres) of a sweep: rotations, centres, one lens for all frames, points of inverse distance.
//
// Three models. `rotation`: every point at infinity. `spherical`: a camera's centre is its own forward axis (radius 1).
// `free`: centres are drawn to that place only weakly, so that the prior decides what the pictures leave open (scale,
// place, the depth of far scenery) and nothing else. Single-threaded and in fixed order: the same input gives the same
// bytes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/base/job.h"
#include "core/poses/tracks/bundle.h"

namespace ldp::sfm {

struct FocalPrior {
  double focal_px = 0;
  double log_sigma = 0.2;
  bool is_guess = false;  // that nobody told: cameras start from it, and tracks by KLT go without
};

enum class MotionModel { rotation, spherical, free };

// How two cameras are turned to each other by the matches of their photos alone, with its deviation. It decides what
// points leave open: where hardly one is seen in three photos, those of two slide along their epipolar lines.
struct StepPrior {
  int a = 0, b = 0;
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  double sigma_rad = 1;
};

struct BundleAdjustmentOptions {
  MotionModel model = MotionModel::free;
  bool refine_focal = true;
  bool refine_distortion = false;
  std::optional<FocalPrior> focal_prior;
  double loss_px = 1;                  // Cauchy scale, at weight 1
  double arc_sigma = 0.2;              // of a free centre about its place on the sphere, radii
  std::vector<StepPrior> step_priors;  // of cameras that turn and move
  double two_view_weight = 1;          // of points that only two cameras see, against those that a third confirms
  bool enforce_cheirality = false;     // points stay on this side of infinity (else a short arc may turn inside out)
  bool correct_curvature = false;      // of the loss: longer steps, near a minimum only
  int max_iterations = 50;
  double function_tolerance = 1e-6;          // share by which the last step lowered the cost
  double initial_trust_region_radius = 1e4;  // of Ceres: the wider, the freer what data constrain little
};

struct BundleAdjustmentSummary {
  double cost = 0;  // half the sum of robust weighted squared residuals, pixels^2
  int iterations = 0;
  bool usable = false;
};

BundleAdjustmentSummary adjust_bundle(Bundle& bundle, const BundleAdjustmentOptions& options, const Job& job);

}  // namespace ldp::sfm
