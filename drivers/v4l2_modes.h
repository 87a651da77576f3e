// Which mode of a camera is wished, and which of a V4L2 device's to use: pure choices, apart from the device.
#pragma once

#include <span>

#include "drivers/interface/camera.h"
#include "drivers/interface/url.h"

namespace ldp {

struct ModeWish {
  int width = 1280, height = 720;
  double fps = 30;
  std::optional<PixelFormat> format;
};

// Of the options width, height, fps and format, the only ones; throws as Url does.
ModeWish wish_from(const Url& url);

// The offered mode nearest to the wish: by format if one is wished, then by size (smallest relative difference of the
// number of pixels and of the shape), then fast enough (at least half of the wished rate), then MJPEG (stored as it
// comes, no work) before NV12 before YUYV before RGB, then by rate. None if nothing fits.
std::optional<CameraMode> choose_mode(std::span<const CameraMode> offers, const ModeWish& wish);

}  // namespace ldp
