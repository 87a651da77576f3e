#include <cstddef>
#include <utility>
#include <vector>

#include "core/poses/poses.h"

namespace ldp {
namespace {

template <typename T>
void keep(const std::vector<bool>& kept, std::vector<T>& values) {
  std::vector<T> left;
  for (size_t i = 0; i < values.size(); ++i) {
    if (kept[i]) left.push_back(std::move(values[i]));
  }
  values = std::move(left);
}

}  // namespace

void leave_out(const std::vector<LeftOut>& why, Poses& poses) {
  std::vector<int> place(why.size(), -1);
  std::vector<bool> kept(why.size());
  int next = 0;
  for (size_t i = 0; i < why.size(); ++i) {
    kept[i] = !why[i];
    if (kept[i]) {
      place[i] = next++;
      continue;
    }
    FrameReport& report = poses.report.frames[static_cast<size_t>(poses.frame_of_camera[i])];
    report.posed = false;
    report.left_out = why[i];
  }
  keep(kept, poses.cameras);
  keep(kept, poses.frame_of_camera);
  std::vector<bool> seen(poses.points.size());
  for (size_t i = 0; i < poses.points.size(); ++i) {
    std::vector<int>& cameras = poses.points[i].cameras;
    std::vector<bool> seeing(cameras.size());
    for (size_t k = 0; k < cameras.size(); ++k) seeing[k] = kept[static_cast<size_t>(cameras[k])];
    keep(seeing, cameras);
    keep(seeing, poses.sightings[i]);
    for (int& camera : cameras) camera = place[static_cast<size_t>(camera)];
    seen[i] = cameras.size() >= 2;
  }
  keep(seen, poses.points);
  keep(seen, poses.sightings);
  poses.report.points = static_cast<int>(poses.points.size());
}

}  // namespace ldp
