// Photographs at the panorama's exposure beside what the panorama shows in their place, one after another.
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/job.h"
#include "core/consistency/consistency.h"
#include "core/panorama/panorama.h"
#include "core/photos/exposure/local_exposure.h"
#include "core/photos/exposure/photo_exposure.h"
#include "core/view/render.h"
#include "core/view/strip_renderer.h"

namespace ldp::consistency {

struct RenderedPhoto {
  RgbImage photo;
  View view;  // with depth
};

class RenderedPhotos {
 public:
  // Refers to both.
  RenderedPhotos(const Evidence& evidence, const LayeredPanorama& panorama);

  // Reads a camera's photograph and makes the panorama ready for it: of each camera, by rising index.
  void prepare(size_t camera, const Job& job);
  // The photograph prepared last, and what is shown in its place.
  RenderedPhoto take(const Job& job);

 private:
  PhotoExposure exposure_of(size_t camera) const;

  const Evidence& evidence_;
  const LayeredPanorama& panorama_;
  LocalExposure local_;
  StripRenderer renderer_;
  size_t camera_ = 0;  // prepared last
  RgbImage photo_;     // its
};

}  // namespace ldp::consistency
