#include "poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "keypoints.h"
#include "pairs.h"
#include "reconstruct.h"

namespace ldp {
namespace {

constexpr double kFovSigma = 0.15;  // of the logarithm of a focal length that someone told
constexpr double kExifSigma = 0.05;
constexpr double kFarthest = 1e4;  // points are put no farther than this many radii

std::optional<FocalPrior> focal_prior(const FrameSource& frames, const PosesOptions& options, int width, int height) {
  if (options.fov_rad) return FocalPrior{0.5 * width / std::tan(0.5 * *options.fov_rad), kFovSigma};
  std::vector<double> hints;
  for (int i = 0; i < frames.size(); ++i) {
    if (const auto hint = frames.focal_hint(i)) hints.push_back(*hint);
  }
  if (hints.empty()) return std::nullopt;
  std::nth_element(hints.begin(), hints.begin() + static_cast<std::ptrdiff_t>(hints.size() / 2), hints.end());
  return FocalPrior{hints[hints.size() / 2] * std::max(width, height), kExifSigma};
}

// World z up: perpendicular to the cameras' right axes, as far as they agree, and to where they look on the whole.
Eigen::Matrix3d upright(const std::vector<Pose>& cameras) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), forward = Eigen::Vector3d::Zero();
  for (const Pose& pose : cameras) up -= pose.world_from_camera.col(1), forward += pose.world_from_camera.col(2);
  up.normalize();
  Eigen::Vector3d y = forward - forward.dot(up) * up;
  if (y.norm() < 1e-6 * static_cast<double>(cameras.size())) y = up.unitOrthogonal();
  y.normalize();
  Eigen::Matrix3d rotation;
  rotation << y.cross(up).transpose(), y.transpose(), up.transpose();
  return rotation;
}

// Slope of centres against forward axes: the radius of a circle whose cameras look outward.
double circle_radius(const std::vector<Pose>& cameras) {
  Eigen::Vector3d c = Eigen::Vector3d::Zero(), f = c;
  const double count = static_cast<double>(cameras.size());
  for (const Pose& pose : cameras) c += pose.centre / count, f += pose.world_from_camera.col(2) / count;
  double above = 0, below = 0;
  for (const Pose& pose : cameras) {
    above += (pose.centre - c).dot(pose.world_from_camera.col(2) - f);
    below += (pose.world_from_camera.col(2) - f).squaredNorm();
  }
  return below > 1e-9 && above > 0.1 * below ? above / below : 1;
}

}  // namespace

Poses estimate_poses(const FrameSource& frames, const PosesOptions& options, const Job& job) {
  if (frames.size() < 3) throw Impossible("at least 3 photos are needed, got " + std::to_string(frames.size()));
  Sweep sweep;
  sweep.features.resize(static_cast<size_t>(frames.size()));
  job.report("features", 0);
  parallel_for(job, frames.size(), [&](int i) {
    sweep.features[static_cast<size_t>(i)] = detect_features(frames.load(i), FeatureOptions{});
  });
  job.report("matching", 0.5);
  PairOptions pairing;
  pairing.seed = options.seed;
  sweep.pairs = match_sweep(sweep.features, pairing, job);
  job.report("adjusting", 0.7);
  const int width = sweep.features[0].width, height = sweep.features[0].height;
  const Reconstruction found = reconstruct(sweep, {focal_prior(frames, options, width, height)}, job);

  const Bundle& bundle = found.bundle;
  const Eigen::Matrix3d turn = upright(bundle.cameras);
  const double scale = options.arm_length / circle_radius(bundle.cameras);
  Poses poses;
  for (int i = 0; i < frames.size(); ++i) {
    const Pose& p = bundle.cameras[static_cast<size_t>(i)];
    Intrinsics k{width, height, bundle.lens.focal_px, bundle.lens.focal_px, 0.5 * width, 0.5 * height};
    k.k1 = bundle.lens.k1, k.k2 = bundle.lens.k2;
    poses.cameras.push_back({frames.name(i), k, {turn * p.world_from_camera, scale * turn * p.centre}});
    poses.frame_of_camera.push_back(i);
    FrameReport report;
    report.name = frames.name(i);
    report.posed = true;
    report.features = sweep.features[static_cast<size_t>(i)].size();
    poses.report.frames.push_back(report);
  }
  double sum = 0;
  for (size_t i = 0; i < found.tracks.size(); ++i) {
    const InversePoint& point = bundle.points[i];
    ScenePoint scene{scale * turn * point.direction / std::max(point.inverse_distance, 1 / kFarthest), {}};
    for (const Observation& o : found.tracks[i]) {
      scene.cameras.push_back(o.frame);
      ++poses.report.frames[static_cast<size_t>(o.frame)].inliers;
    }
    poses.points.push_back(scene);
  }
  for (const BundleObservation& o : bundle.observations) {
    const Projection p = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens,
                                       bundle.points[static_cast<size_t>(o.point)]);
    sum += (p.position_px - o.position_px).squaredNorm();
  }
  poses.report.reprojection_px = std::sqrt(sum / static_cast<double>(std::max<size_t>(1, bundle.observations.size())));
  poses.report.points = static_cast<int>(poses.points.size());
  return poses;
}

}  // namespace ldp
