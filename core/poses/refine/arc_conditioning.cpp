#include "core/poses/refine/arc_conditioning.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/poses/refine/refine_tuning.h"

namespace ldp::sfm {
std::vector<int> tracks_through_frame(const Reconstruction& r) {
  std::vector<int> between(r.bundle.cameras.size(), 0);
  for (const Track& track : r.tracks) {
    for (size_t i = 1; i + 1 < track.size(); ++i) ++between[static_cast<size_t>(track[i].frame)];
  }
  return between;
}

bool is_ill_conditioned(const Reconstruction& r) {
  if (r.motion != Motion::arc || r.closed) return false;
  const std::vector<int> between = tracks_through_frame(r);
  std::vector<size_t> posed;
  for (size_t i = 0; i < between.size(); ++i) {
    if (!r.left_out[i]) posed.push_back(i);
  }
  double swept = 0, open = 0;  // radians; squares of shares
  for (size_t i = 1; i < posed.size(); ++i) {
    const Pose &p = r.bundle.cameras[posed[i - 1]], &q = r.bundle.cameras[posed[i]];
    swept += Eigen::AngleAxisd(p.world_from_camera.transpose() * q.world_from_camera).angle();
    if (i + 1 < posed.size()) open += 1.0 / (between[posed[i]] + 1);
  }
  return posed.size() > 2 && swept / static_cast<double>(posed.size() - 2) * std::sqrt(open) > kMaxArcError_rad;
}

}  // namespace ldp::sfm
