#include "core/consistency/rendered_photos.h"

namespace ldp::consistency {
RenderedPhotos::RenderedPhotos(const Evidence& evidence, const LayeredPanorama& panorama)
    : evidence_(evidence), panorama_(panorama), local_(panorama.cameras, evidence.gains), renderer_(panorama) {}

RenderedPhoto RenderedPhotos::take(size_t camera, const Job& job, const std::vector<Observer*>& observers) {
  RenderedPhoto taken{evidence_.frames.load(evidence_.frame_of_camera[camera]), {}};
  for (Observer* observer : observers) observer->taken(camera, taken.photo);
  exposure_of(camera).apply(taken.photo);
  RenderOptions options;
  options.depth = true;
  options.outlines = false;  // colours are drawn to the photographs surface by surface
  taken.view = renderer_.render(panorama_.cameras[camera], options, job);
  return taken;
}

PhotoExposure RenderedPhotos::exposure_of(size_t camera) const {
  if (panorama_.exposure.empty()) return PhotoExposure(evidence_.gains[camera]);
  const Intrinsics& lens = panorama_.cameras[camera].intrinsics;
  return {{local_.over_photo(camera), panorama_.exposure.response}, lens.width, lens.height};
}

}  // namespace ldp::consistency
