// The front layer resampled to equal angles, and which part of the sphere it shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

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

// Of two whole spheres, one above the other: GPano's projection and, as players look for it, GSpherical's stereo mode.
std::string stereo_xmp(const LayeredPanorama& panorama);

// The file's bytes by its ending, .png or JPEG, with a packet of metadata.
std::vector<uint8_t> picture_file(const std::string& ending, const RgbImage& image, const std::string& xmp,
                                  const LayeredPanorama& panorama, int jpeg_quality);

}  // namespace ldp
