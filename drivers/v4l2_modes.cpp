#include "drivers/v4l2_modes.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace ldp {
namespace {

double size_difference(const CameraMode& mode, const ModeWish& wish) {
  const double pixels = std::log(double(mode.width) * mode.height) - std::log(double(wish.width) * wish.height);
  const double shape = std::log(double(mode.width) / mode.height) - std::log(double(wish.width) / wish.height);
  return std::abs(pixels) + 2 * std::abs(shape);
}

int effort(PixelFormat format) {
  switch (format) {
    case PixelFormat::mjpeg:
      return 0;
    case PixelFormat::nv12:
      return 1;
    case PixelFormat::yuyv:
      return 2;
    case PixelFormat::rgb24:
    case PixelFormat::bgr24:
      return 3;
  }
  return 4;
}

// Rates too slow for a sweep come last, unknown rates (0) before them; among the others nearer to the wish is better.
double slowness(const CameraMode& mode, const ModeWish& wish) {
  if (mode.fps <= 0) return 1;
  return mode.fps < wish.fps / 2 ? 2 : 0;
}

}  // namespace

ModeWish wish_from(const Url& url) {
  url.allow_only("width height fps format");
  ModeWish wish;
  wish.width = url.integer("width", wish.width, {16, 16384});
  wish.height = url.integer("height", wish.height, {16, 16384});
  wish.fps = url.number("fps", wish.fps, {1, 1000});
  const std::string format = url.word("format", "");
  using enum PixelFormat;
  for (const PixelFormat known : {mjpeg, yuyv, nv12, rgb24, bgr24}) {
    if (format == name_of(known)) wish.format = known;
  }
  if (!format.empty() && !wish.format) {
    throw std::runtime_error("'" + url.text() + "': format is '" + format +
                             "', expected mjpeg, yuyv, nv12, rgb24 or bgr24");
  }
  return wish;
}

std::optional<CameraMode> choose_mode(std::span<const CameraMode> offers, const ModeWish& wish) {
  const auto rank = [&](const CameraMode& mode) {
    const double difference = std::round(size_difference(mode, wish) * 100);  // 1 % either way is the same size
    return std::make_tuple(slowness(mode, wish) == 2, difference, slowness(mode, wish), effort(mode.format),
                           std::abs(mode.fps - wish.fps));
  };
  std::optional<CameraMode> best;
  for (const CameraMode& mode : offers) {
    if (wish.format && mode.format != *wish.format) continue;
    if (mode.width <= 0 || mode.height <= 0) continue;
    if (!best || rank(mode) < rank(*best)) best = mode;
  }
  return best;
}

}  // namespace ldp
