// Pixels of a camera frame of any format: small and grey for judging it, whole for storing it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/plane.h"
#include "core/photos/images.h"
#include "drivers/interface/camera.h"

namespace ldp {

constexpr int kThumbnailWidth = 96;  // pixels, about: the nearest whole reduction

// That of a JPEG is what its own header tells, whatever the camera promised. Throws std::runtime_error for a damaged
// one.
ImageSize stored_size(const CameraFrame& frame);

// A grey picture of about kThumbnailWidth columns, averaged over squares. Throws std::runtime_error for a damaged JPEG.
GreyImage thumbnail(const CameraFrame& frame);

// How sharp a frame is compared with others of the same scene and camera: JPEG files by their size (a fixed quality
// spends more bytes on more detail), pictures by the mean steps between neighbouring luminances.
double sharpness(const CameraFrame& frame);

// The file to store: JPEG frames byte by byte, everything else encoded as JPEG of quality 95.
std::vector<uint8_t> jpeg_from(const CameraFrame& frame);

}  // namespace ldp
