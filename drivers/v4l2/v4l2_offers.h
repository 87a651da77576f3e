// What a V4L2 device offers: pixel formats, sizes and rates that are known here.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/interface/camera.h"
#include "drivers/v4l2_modes.h"

namespace ldp::v4l2 {

struct Offer {
  CameraMode mode;
  uint32_t code = 0;  // of the pixel format, the kernel's
};

std::optional<PixelFormat> format_from(uint32_t code);

// 0 where the driver does not say.
double fps_from(const v4l2_fract& interval);

// Every size of every known format, each with the rate nearest to the wish; of sizes in steps the nearest to the wish.
// `type`: V4L2_BUF_TYPE_VIDEO_CAPTURE or ..._MPLANE.
std::vector<Offer> offers_of(int fd, uint32_t type, const ModeWish& wish);

}  // namespace ldp::v4l2
