#include <Eigen/Core>
#include <cmath>

#include "core/arc/arc.h"
#include "core/arc/arc_tuning.h"

namespace ldp {

using namespace arcs;

namespace {

// Steps from camera to camera, in each camera's axes, are added up with their signs: what a hand sways cancels out.
struct Steps {
  double nod = 0, pan = 0;     // sines of angles
  double down = 0, aside = 0;  // of the way
  double length = 0;           // of the path

  explicit Steps(const std::vector<Camera>& cameras) {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero(), way = Eigen::Vector3d::Zero();
    for (size_t i = 1; i < cameras.size(); ++i) {
      const Pose &from = cameras[i - 1].pose, &to = cameras[i].pose;
      const Eigen::Matrix3d r = from.world_from_camera.transpose() * to.world_from_camera;
      turn += 0.5 * Eigen::Vector3d(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
      way += from.world_from_camera.transpose() * (to.centre - from.centre);
      length += (to.centre - from.centre).norm();
    }
    nod = std::abs(turn.x()), pan = std::abs(turn.y());
    down = std::abs(way.y()), aside = std::abs(way.x());
  }
  bool turns() const { return std::max(nod, pan) > kLeastTurn_rad; }
};

}  // namespace

bool nods(const std::vector<Camera>& cameras) {
  const Steps steps(cameras);
  return steps.turns() && steps.nod > kClearly * steps.pan;
}

std::string sideways(const std::vector<Camera>& cameras) {
  const Steps steps(cameras);
  const bool moves_down = steps.down > kClearly * steps.aside && steps.down > kLeastShare * steps.length;
  if (steps.turns() ? !nods(cameras) : !moves_down) return {};
  return "the sweep goes up or down in the photos: where the camera lay on its side, a turn by 90 or by 270 degrees "
         "shows things upright, where it stood upright, no turn";
}

}  // namespace ldp
