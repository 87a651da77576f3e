// What the image formats offer each other inside this folder. Every function throws std::runtime_error that begins with
// the given name.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/plane.h"
#include "core/photos/images.h"

namespace ldp {

struct ScaledImage {
  RgbImage image;
  ImageSize full_size;
  double scale = 1;
};

struct Exif {
  int orientation = 1;               // 1 .. 8, as EXIF numbers them
  std::optional<double> focal_hint;  // focal length / longer side
};

bool is_jpeg(std::span<const uint8_t> bytes);
bool is_png(std::span<const uint8_t> bytes);
bool is_webp(std::span<const uint8_t> bytes);

ImageSize jpeg_size(std::span<const uint8_t> bytes, const std::string& name);
ImageSize png_size(std::span<const uint8_t> bytes, const std::string& name);
ImageSize webp_size(std::span<const uint8_t> bytes, const std::string& name);
ScaledImage decode_jpeg(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels);
ScaledImage decode_png(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels);
ScaledImage decode_webp(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels);

Exif read_exif(std::span<const uint8_t> jpeg, ImageSize size);

void check_size(int64_t width, int64_t height, const std::string& name);
[[noreturn]] void refuse_too_large(ImageSize size, int64_t max_pixels, const std::string& name);
[[noreturn]] void refuse_damaged(const std::string& name, const std::string& format, const std::string& what);

}  // namespace ldp
