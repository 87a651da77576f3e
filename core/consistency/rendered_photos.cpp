#include "core/consistency/rendered_photos.h"

#include <algorithm>

namespace ldp::consistency {
namespace {

constexpr int kUnits = 16;

void even_exposure(const Gain& gain, RgbImage& photo) {
  if (gain == Gain{1, 1, 1}) return;
  const ExposureGain evened(gain);
  const auto stored = [](int v) { return static_cast<uint8_t>(std::clamp((v + kUnits / 2) / kUnits, 0, 255)); };
  for (Rgb& c : photo.samples) {
    const auto e = evened({c.r * kUnits, c.g * kUnits, c.b * kUnits}, kUnits);
    c = {stored(e[0]), stored(e[1]), stored(e[2])};
  }
}

}  // namespace

RenderedPhotos::RenderedPhotos(const Evidence& evidence, const LayeredPanorama& panorama)
    : evidence_(evidence), panorama_(panorama), renderer_(panorama) {}

RenderedPhoto RenderedPhotos::take(size_t camera, const Job& job, Observer* observer) {
  RenderedPhoto taken{evidence_.frames.load(evidence_.frame_of_camera[camera]), {}};
  if (observer != nullptr) observer->taken(camera, taken.photo);
  even_exposure(evidence_.gains[camera], taken.photo);
  RenderOptions options;
  options.depth = true;
  taken.view = renderer_.render(panorama_.cameras[camera], options, job);
  return taken;
}

}  // namespace ldp::consistency
