#include "core/view/framing.h"

#include <algorithm>

#include "core/view/view_tuning.h"

namespace ldp {
namespace {

using namespace view;  // tuned constants

constexpr RenderOptions kGlance{.outlines = false};  // a crack of a small view is wide in a full one

class Framing {
 public:
  Framing(const LayeredPanorama& panorama, const Renderer& renderer, const CameraPathOptions& path, const Job& job)
      : panorama_(panorama), renderer_(renderer), job_(job), path_(path), zooms_(path.view_rad == 0) {
    path_.frames = kGlances;
    path_.height = std::max(1, path.height * kGlancePx / path.width);
    path_.width = kGlancePx;
  }

  // Of the path wanted only how it is framed changes.
  CameraPathOptions framed(CameraPathOptions wanted) {
    for (int i = 0; i < kAimings && !fits(); ++i) aim();
    find_way();
    wanted.zoom = path_.zoom, wanted.reach = path_.reach;
    wanted.turn_rad = path_.turn_rad, wanted.rise = path_.rise;
    return wanted;
  }

 private:
  void find_way() {
    for (const double reach : kReaches) {
      path_.reach = reach, path_.zoom = 1;
      if (fits() || (zooms_ && zoom_in(kClosest))) return;
    }
    if (zooms_) zoom_in(kVeryClosest);
  }

  // The least zoom that fits, between 1 and `closest`; false, and that, where none does.
  bool zoom_in(double closest) {
    path_.zoom = closest;
    if (!fits()) return false;
    double low = 1, high = closest;
    for (int i = 0; i < kZoomSteps; ++i) {
      path_.zoom = 0.5 * (low + high);
      (fits() ? high : low) = path_.zoom;
    }
    path_.zoom = high;
    return true;
  }

  bool fits() const {
    for (const Camera& camera : camera_path(panorama_, path_))
      if (unseen(renderer_.render(camera, kGlance, job_)) > kUnseen) return false;
    return true;
  }

  static double unseen(const View& view) {
    const auto holes = std::count_if(view.alpha.samples.begin(), view.alpha.samples.end(), is_hole);
    return static_cast<double>(holes) / static_cast<double>(view.alpha.samples.size());
  }

  static bool is_hole(uint8_t alpha) { return alpha < 128; }

  // Turns the path to the middle of what its views show: walks keep looking outwards.
  void aim() {
    double seen = 0, right = 0, down = 0;
    const std::vector<Camera> cameras = camera_path(panorama_, path_);
    for (const Camera& camera : cameras) {
      const View view = renderer_.render(camera, kGlance, job_);
      for (int y = 0; y < view.alpha.height; ++y)
        for (int x = 0; x < view.alpha.width; ++x)
          if (!is_hole(view.alpha.at(x, y))) ++seen, right += x + 0.5, down += y + 0.5;
    }
    if (seen == 0) return;
    const Intrinsics& k = cameras.front().intrinsics;
    path_.rise -= (down / seen - k.cy) / k.fy;
    if (path_.kind != CameraPath::walk) path_.turn_rad += (right / seen - k.cx) / k.fx;
  }

  const LayeredPanorama& panorama_;
  const Renderer& renderer_;
  const Job& job_;
  CameraPathOptions path_;  // of the small views
  const bool zooms_;
};

}  // namespace

CameraPathOptions framed_inside(const LayeredPanorama& panorama, const Renderer& renderer, CameraPathOptions path,
                                const Job& job) {
  check_camera_path(path);
  return Framing(panorama, renderer, path, job).framed(path);
}

}  // namespace ldp
