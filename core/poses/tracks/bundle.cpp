#include "core/poses/tracks/bundle.h"

namespace ldp::sfm {

Eigen::Vector2d undistorted_ray(const Eigen::Vector2d& position_px, const Lens& lens) {
  const Intrinsics k{0, 0, lens.focal_px, lens.focal_px, 0, 0, lens.k1, lens.k2, 0, 0};
  return unproject(k, position_px).head<2>();
}

Projection project_point(const Pose& camera, const Lens& lens, const InversePoint& point) {
  const Eigen::Vector3d p = camera.world_from_camera.transpose() * point.seen_from(camera.centre);
  if (p.z() < kMinDepth) return {};
  return {lens.focal_px * distort(p.head<2>() / p.z(), lens.k1, lens.k2).position, true};
}

void add_point(const Track& track, const InversePoint& point, Bundle& bundle) {
  const int index = static_cast<int>(bundle.points.size());
  bundle.points.push_back(point);
  for (const Observation& o : track) bundle.observations.push_back({o.frame, index, o.position_px, o.weight});
}

}  // namespace ldp::sfm
