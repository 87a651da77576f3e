#include "core/poses/start/motion_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/poses/start/start_tuning.h"
#include "core/poses/tracks/track_triangulation.h"

namespace ldp::sfm {
namespace {

std::vector<Pose> posed_cameras(const std::vector<LeftOut>& left_out, const Bundle& bundle) {
  std::vector<Pose> cameras;
  for (size_t i = 0; i < left_out.size(); ++i) {
    if (!left_out[i]) cameras.push_back(bundle.cameras[i]);
  }
  return cameras;
}

double outlier_share(const Bundle& bundle, double tolerance_px) {
  int beyond = 0;
  for (const BundleObservation& o : bundle.observations) {
    const Projection p = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens,
                                       bundle.points[static_cast<size_t>(o.point)]);
    if (!p.in_front || (p.position_px - o.position_px).norm() > tolerance_px) ++beyond;
  }
  return beyond / std::max(1.0, static_cast<double>(bundle.observations.size()));
}

// Centres as C + r forward, and whether that explains enough of their spread for an arc.
struct Circle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;
  bool bends = false;
};

Circle fit_circle(const std::vector<Pose>& cameras) {
  Eigen::Vector3d c = Eigen::Vector3d::Zero(), f = c;
  const double count = static_cast<double>(cameras.size());
  for (const Pose& pose : cameras) c += pose.centre / count, f += pose.world_from_camera.col(2) / count;
  double both = 0, centres = 0, forwards = 0;
  for (const Pose& pose : cameras) {
    const Eigen::Vector3d dc = pose.centre - c, df = pose.world_from_camera.col(2) - f;
    both += dc.dot(df);
    centres += dc.squaredNorm();
    forwards += df.squaredNorm();
  }
  const double turn = std::sqrt(12 * forwards / count);  // of a path that turns evenly
  const double radius = forwards > 0 ? both / forwards : 0;
  return {c - radius * f, radius, both > 0 && both * both > kMinArcShare * centres * forwards && turn > kMinArc_rad};
}

// Azimuths of the lines of sight about the mean up, sorted, with the widest gap: where the sweep would be open.
struct Seam {
  double gap = 2 * std::numbers::pi;
  double middle = 0;  // azimuth
};

Eigen::Vector3d mean_up(const std::vector<Pose>& cameras) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const Pose& pose : cameras) up -= pose.world_from_camera.col(1);
  return up.normalized();
}

double azimuth(const Pose& pose, const Eigen::Vector3d& e1, const Eigen::Vector3d& e2) {
  const Eigen::Vector3d f = pose.world_from_camera.col(2);
  return std::atan2(f.dot(e2), f.dot(e1));
}

Seam widest_gap(std::vector<double> azimuths) {
  std::sort(azimuths.begin(), azimuths.end());
  Seam seam{0, 0};
  for (size_t i = 0; i < azimuths.size(); ++i) {
    const bool last = i + 1 == azimuths.size();
    const double gap = (last ? azimuths[0] + 2 * std::numbers::pi : azimuths[i + 1]) - azimuths[i];
    if (gap > seam.gap) seam = {gap, azimuths[i] + 0.5 * gap};
  }
  return seam;
}

// Closed: all round, and points are seen from both sides of the widest gap.
bool closes(const MatchedSweep& sweep, const Reconstruction& r) {
  const std::vector<Pose> cameras = posed_cameras(r.left_out, r.bundle);
  const Eigen::Vector3d up = mean_up(cameras), e1 = up.unitOrthogonal(), e2 = up.cross(e1);
  std::vector<double> azimuths;
  for (const Pose& pose : cameras) azimuths.push_back(azimuth(pose, e1, e2));
  const Seam seam = widest_gap(azimuths);
  const double view = 2 * std::atan2(0.5 * sweep.features[0].width, r.bundle.lens.focal_px);
  if (seam.gap > kMaxClosedGap * view) return false;
  int across = 0;
  for (const Track& track : r.tracks) {
    bool before = false, behind = false;
    for (const Observation& o : track) {
      const double from = std::remainder(azimuth(r.bundle.cameras[static_cast<size_t>(o.frame)], e1, e2) - seam.middle,
                                         2 * std::numbers::pi);
      (from < 0 ? before : behind) = true;
    }
    across += before && behind ? 1 : 0;
  }
  return across >= kMinSeamTracks;
}

// Cameras and lens that explain the longest tracks best if all of it were far; with a distortion of its own, or the one
// that it has.
Bundle rotating(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& from, bool refine_distortion,
                const Job& job) {
  Bundle rotation = from;
  triangulate_tracks(longest_tracks(tracks, sweep, kParallaxObservationsPerFrame), rotation);
  for (InversePoint& point : rotation.points) point.inverse_distance = 0;
  BundleAdjustmentOptions options;
  options.model = MotionModel::rotation;
  options.refine_distortion = refine_distortion;
  options.loss_px = sweep.pixels(0.5 * kParallax_px);
  adjust_bundle(rotation, options, job);
  return rotation;
}

}  // namespace

bool is_pure_rotation(const MatchedSweep& sweep, const std::vector<Track>& tracks, Bundle& bundle, const Job& job) {
  const Bundle rotation = rotating(sweep, tracks, bundle, true, job);
  if (outlier_share(rotation, sweep.pixels(kParallax_px)) > kMaxParallaxShare) return false;
  bundle = rotation;
  return true;
}

bool is_false_arc(const MatchedSweep& sweep, const std::vector<Track>& tracks, Bundle& bundle, const Job& job) {
  const Bundle rotation = rotating(sweep, tracks, bundle, false, job);
  const double log_focal = std::abs(std::log(rotation.lens.focal_px / bundle.lens.focal_px));
  if (log_focal < kMinFalseArcLogFocal) return false;
  const double unexplained = outlier_share(rotation, sweep.pixels(kShaking_px));
  if (unexplained > std::min(kMaxShakingShare, kMaxShakingPerLogFocal * log_focal)) return false;
  bundle = rotation;
  return true;
}

bool normalise_to_sphere(const std::vector<LeftOut>& left_out, Bundle& bundle) {
  const Circle circle = fit_circle(posed_cameras(left_out, bundle));
  if (!circle.bends) return false;
  for (Pose& pose : bundle.cameras) pose.centre = (pose.centre - circle.centre) / circle.radius;
  return true;
}

double motion_roughness(const std::vector<LeftOut>& left_out, const Bundle& bundle) {
  const std::vector<Pose> cameras = posed_cameras(left_out, bundle);
  if (cameras.size() < 2) return 0;
  std::vector<Eigen::Vector3d> steps;  // less those of the sphere, in the camera's axes
  for (size_t i = 1; i < cameras.size(); ++i) {
    const Eigen::Vector3d off = cameras[i].centre - cameras[i].world_from_camera.col(2) -
                                (cameras[i - 1].centre - cameras[i - 1].world_from_camera.col(2));
    steps.push_back(cameras[i - 1].world_from_camera.transpose() * off);
  }
  Eigen::Vector3d shared;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& step : steps) values.push_back(step[axis]);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    shared[axis] = *middle;
  }
  double sum = 0;
  for (const Eigen::Vector3d& step : steps) sum += (step - shared).norm();
  return sum / static_cast<double>(steps.size());
}

void classify_motion(const MatchedSweep& sweep, Reconstruction& reconstruction) {
  reconstruction.motion =
      fit_circle(posed_cameras(reconstruction.left_out, reconstruction.bundle)).bends ? Motion::arc : Motion::straight;
  reconstruction.closed = closes(sweep, reconstruction);
}

}  // namespace ldp::sfm
