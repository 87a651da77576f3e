#include "core/consistency/rendered_photos.h"

#include <utility>

namespace ldp::consistency {
RenderedPhotos::RenderedPhotos(const Evidence& evidence, const LayeredPanorama& panorama)
    : evidence_(evidence), panorama_(panorama), local_(panorama.cameras, evidence.gains), renderer_(panorama) {}

void RenderedPhotos::prepare(size_t camera, const Job& job) {
  camera_ = camera;
  photo_ = evidence_.frames.load(evidence_.frame_of_camera[camera]);
  exposure_of(camera).apply(photo_);
  renderer_.prepare(panorama_.cameras[camera], job);
}

RenderedPhoto RenderedPhotos::take(const Job& job) {
  RenderOptions options;
  options.depth = true;
  options.outlines = false;  // colours are drawn to the photographs surface by surface
  return {std::move(photo_), renderer_.render(panorama_.cameras[camera_], options, job)};
}

PhotoExposure RenderedPhotos::exposure_of(size_t camera) const {
  if (panorama_.exposure.empty()) return PhotoExposure(evidence_.gains[camera]);
  const Intrinsics& lens = panorama_.cameras[camera].intrinsics;
  return {{local_.over_photo(camera), panorama_.exposure.response}, lens.width, lens.height};
}

}  // namespace ldp::consistency
