#include "drivers/v4l2/v4l2_offers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/v4l2/v4l2_ioctl.h"

namespace ldp::v4l2 {
namespace {

constexpr double kSettle_s = 0.5;  // automatic exposure after the start of the stream

struct FourCc {
  uint32_t code;
  PixelFormat format;
};
constexpr std::array kFourCcs = {
    FourCc{V4L2_PIX_FMT_MJPEG, PixelFormat::mjpeg}, FourCc{V4L2_PIX_FMT_JPEG, PixelFormat::mjpeg},
    FourCc{V4L2_PIX_FMT_YUYV, PixelFormat::yuyv},   FourCc{V4L2_PIX_FMT_NV12, PixelFormat::nv12},
    FourCc{V4L2_PIX_FMT_RGB24, PixelFormat::rgb24}, FourCc{V4L2_PIX_FMT_BGR24, PixelFormat::bgr24}};

// The rate nearest to the wish at one size; 0 if the driver does not say.
double best_fps(int fd, uint32_t code, uint32_t width, uint32_t height, double wish) {
  double best = 0;
  const auto consider = [&](double fps) {
    if (fps > 0 && (best == 0 || std::abs(fps - wish) < std::abs(best - wish))) best = fps;
  };
  for (uint32_t index = 0; index < 64; ++index) {
    v4l2_frmivalenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    entry.width = width;
    entry.height = height;
    if (call(fd, VIDIOC_ENUM_FRAMEINTERVALS, &entry) != 0) break;
    if (entry.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      consider(fps_from(entry.discrete));
      continue;
    }
    const double fastest = fps_from(entry.stepwise.min), slowest = fps_from(entry.stepwise.max);
    consider(std::min(fastest, std::max(slowest, wish)));
    break;
  }
  return best;
}

uint32_t nearest_step(uint32_t wish, uint32_t low, uint32_t high, uint32_t step) {
  const uint32_t inside = std::min(std::max(wish, low), high);
  return low + (inside - low) / std::max(step, 1U) * std::max(step, 1U);
}

void add_sizes(int fd, uint32_t code, const ModeWish& wish, std::vector<Offer>& offers) {
  const auto format = format_from(code);
  const auto add = [&](uint32_t width, uint32_t height) {
    const double fps = best_fps(fd, code, width, height, wish.fps);
    offers.push_back({{*format, static_cast<int>(width), static_cast<int>(height), fps, kSettle_s}, code});
  };
  for (uint32_t index = 0; index < 256; ++index) {
    v4l2_frmsizeenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    if (call(fd, VIDIOC_ENUM_FRAMESIZES, &entry) != 0) {
      if (index == 0) add(static_cast<uint32_t>(wish.width), static_cast<uint32_t>(wish.height));
      return;
    }
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      add(entry.discrete.width, entry.discrete.height);
      continue;
    }
    const auto& range = entry.stepwise;
    add(nearest_step(static_cast<uint32_t>(wish.width), range.min_width, range.max_width, range.step_width),
        nearest_step(static_cast<uint32_t>(wish.height), range.min_height, range.max_height, range.step_height));
    return;
  }
}

}  // namespace

std::optional<PixelFormat> format_from(uint32_t code) {
  for (const FourCc& known : kFourCcs) {
    if (known.code == code) return known.format;
  }
  return std::nullopt;
}

double fps_from(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : double(interval.denominator) / interval.numerator;
}

std::vector<Offer> offers_of(int fd, uint32_t type, const ModeWish& wish) {
  std::vector<Offer> offers;
  for (uint32_t index = 0; index < 128; ++index) {
    v4l2_fmtdesc entry{};
    entry.index = index;
    entry.type = type;
    if (call(fd, VIDIOC_ENUM_FMT, &entry) != 0) break;
    if (format_from(entry.pixelformat)) add_sizes(fd, entry.pixelformat, wish, offers);
  }
  return offers;
}

}  // namespace ldp::v4l2
