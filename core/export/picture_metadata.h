// What picture files tell of a panorama: EXIF (time, device) and XMP packets (which part of the sphere it is, two eyes,
// depth), and the files themselves.
//
// Depth as photo programs know it (GDepth, https://developers.google.com/depthmap-metadata): a grey PNG of 16 bits in
// base64, format RangeInverse, measured along each pixel's ray (OpticRay). In a JPEG it stands in extended XMP.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/export/equirectangular.h"
#include "core/panorama/panorama.h"

namespace ldp {

// The XMP packet with GPano's description of the image.
std::string gpano_xmp(const FlatPanorama& flat, const LayeredPanorama& panorama);

// Of two whole spheres, one above the other: GPano's projection and, as players look for it, GSpherical's stereo mode.
std::string stereo_xmp(const LayeredPanorama& panorama);

// The file's bytes by its ending, .png or JPEG, with a packet of metadata.
std::vector<uint8_t> picture_file(const std::string& ending, const RgbImage& image, const std::string& xmp,
                                  const LayeredPanorama& panorama, int jpeg_quality);

// Code c of 16 bits is the distance d of 1 / d = 1 / nearest + c / 65535 (1 / farthest - 1 / nearest), both in the
// capture's unit. What is farther than `farthest`, or at infinity, has code 65535.
struct RangeInverse {
  double nearest = 1, farthest = 2;
  Plane<uint16_t> codes;
};
// Of a picture that was seen from a place (around.h).
RangeInverse range_inverse(const FlatPanorama& flat);

// .jpg: the picture, depth inside. .png: depth alone, 16 bits, with the same words on it.
std::vector<uint8_t> depth_file(const std::string& ending, const FlatPanorama& flat, const LayeredPanorama& panorama,
                                int jpeg_quality);

}  // namespace ldp
