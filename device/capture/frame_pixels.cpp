#include "device/capture/frame_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "device/capture/capture_tuning.h"

namespace ldp {
namespace {

// Where luminance lies in a raw format: bytes from pixel to pixel, and of the first one. RGB is judged by its green.
struct Luminance {
  int step = 1, first = 0;
};

Luminance luminance_of(PixelFormat format) {
  switch (format) {
    case PixelFormat::yuyv:
      return {2, 0};
    case PixelFormat::rgb24:
    case PixelFormat::bgr24:
      return {3, 1};
    case PixelFormat::nv12:
    case PixelFormat::mjpeg:
      break;
  }
  return {1, 0};
}

GreyImage shrink(const uint8_t* bytes, int stride, Luminance luminance, int width, int height) {
  const int factor = std::max(1, (width + kThumbnailWidth / 2) / kThumbnailWidth);
  GreyImage small(std::max(1, width / factor), std::max(1, height / factor));
  const int across = std::min(factor, width), down = std::min(factor, height);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      int sum = 0;
      for (int v = 0; v < down; ++v) {
        const uint8_t* pixel =
            bytes + ptrdiff_t{y * factor + v} * stride + ptrdiff_t{x} * factor * luminance.step + luminance.first;
        for (int u = 0; u < across; ++u) sum += pixel[ptrdiff_t{u} * luminance.step];
      }
      small.at(x, y) = static_cast<uint8_t>(sum / (across * down));
    }
  }
  return small;
}

uint8_t clamped(int value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); }

// Full-range BT.601 as JPEG has it; cameras' limited range is left as it is (it is undone by no one who stores MJPEG
// either, and gains are estimated later).
Rgb rgb_from(int y, int u, int v) {
  const int blue = u - 128, red = v - 128;
  return {clamped(y + (91881 * red + 32768) / 65536), clamped(y - (22554 * blue + 46802 * red + 32768) / 65536),
          clamped(y + (116130 * blue + 32768) / 65536)};
}

RgbImage rgb_from(const CameraFrame& frame) {
  RgbImage image(frame.width, frame.height);
  for (int y = 0; y < frame.height; ++y) {
    const uint8_t* row = frame.planes[0].bytes + ptrdiff_t{y} * frame.planes[0].stride;
    Rgb* out = image.row(y);
    switch (frame.format) {
      case PixelFormat::yuyv:
        for (int x = 0; x < frame.width; ++x) {
          const uint8_t* pair = row + ptrdiff_t{x / 2} * 4;
          out[x] = rgb_from(row[ptrdiff_t{2} * x], pair[1], pair[3]);
        }
        break;
      case PixelFormat::nv12: {
        const uint8_t* chroma = frame.planes[1].bytes + ptrdiff_t{y / 2} * frame.planes[1].stride;
        for (int x = 0; x < frame.width; ++x)
          out[x] = rgb_from(row[x], chroma[ptrdiff_t{x / 2} * 2], chroma[ptrdiff_t{x / 2} * 2 + 1]);
        break;
      }
      case PixelFormat::rgb24:
        for (int x = 0; x < frame.width; ++x, row += 3) out[x] = {row[0], row[1], row[2]};
        break;
      case PixelFormat::bgr24:
        for (int x = 0; x < frame.width; ++x, row += 3) out[x] = {row[2], row[1], row[0]};
        break;
      case PixelFormat::mjpeg:
        throw std::logic_error("a JPEG frame needs no encoding");
    }
  }
  return image;
}

}  // namespace

ImageSize stored_size(const CameraFrame& frame) {
  const FramePlane& plane = frame.planes.at(0);
  if (frame.format != PixelFormat::mjpeg) return {frame.width, frame.height};
  return image_size({plane.bytes, plane.size}, "camera frame");
}

GreyImage thumbnail(const CameraFrame& frame) {
  const FramePlane& plane = frame.planes.at(0);
  if (frame.format != PixelFormat::mjpeg) {
    return shrink(plane.bytes, plane.stride, luminance_of(frame.format), frame.width, frame.height);
  }
  const int64_t pixels = int64_t{frame.width} * frame.height;
  const int64_t enough =
      std::max<int64_t>(pixels / 64 + frame.width + frame.height, int64_t{4} * kThumbnailWidth * kThumbnailWidth);
  const RgbImage image = decode_image({plane.bytes, plane.size}, "camera frame", enough);
  return shrink(&image.samples.data()->r, image.width * 3, luminance_of(PixelFormat::rgb24), image.width, image.height);
}

double sharpness(const CameraFrame& frame) {
  const FramePlane& plane = frame.planes.at(0);
  if (frame.format == PixelFormat::mjpeg) return static_cast<double>(plane.size);
  const Luminance luminance = luminance_of(frame.format);
  int64_t steps = 0, count = 0;
  for (int y = 0; y < frame.height; y += 8) {
    const uint8_t* row = plane.bytes + ptrdiff_t{y} * plane.stride + luminance.first;
    for (int x = 1; x < frame.width; ++x) {
      const int step = row[ptrdiff_t{x} * luminance.step] - row[ptrdiff_t{x - 1} * luminance.step];
      steps += int64_t{step} * step;
    }
    count += frame.width - 1;
  }
  return count > 0 ? std::sqrt(static_cast<double>(steps) / static_cast<double>(count)) : 0;
}

std::vector<uint8_t> jpeg_from(const CameraFrame& frame) {
  const FramePlane& plane = frame.planes.at(0);
  if (frame.format == PixelFormat::mjpeg) return {plane.bytes, plane.bytes + plane.size};
  return encode_jpeg(rgb_from(frame), kJpegQuality);
}

}  // namespace ldp
