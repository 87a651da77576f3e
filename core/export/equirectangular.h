// The front layer resampled to equal angles, and which part of the sphere it shows.
#pragma once

#include <string>

#include "core/panorama/panorama.h"

namespace ldp {

struct FlatPanorama {
  RgbImage image;
  int full_width = 0, full_height = 0;  // of the whole sphere at this resolution
  int left = 0, top = 0;                // of the image in it
};

FlatPanorama flatten(const LayeredPanorama& panorama);

// The XMP packet with GPano's description of the image.
std::string gpano_xmp(const FlatPanorama& flat, const LayeredPanorama& panorama);

}  // namespace ldp
