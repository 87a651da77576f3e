#include "core/photos/images.h"

#include <stdexcept>
#include <utility>

#include "core/base/files.h"
#include "core/photos/codecs/formats.h"

namespace ldp {
namespace {

[[noreturn]] void refuse_content(const std::string& name) {
  throw DamagedImage(name + ": neither a JPEG nor a PNG nor a WebP file: copy it again, or leave it out");
}

ScaledImage decode(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels) {
  if (is_jpeg(bytes)) return decode_jpeg(bytes, name, max_pixels);
  if (is_png(bytes)) return decode_png(bytes, name, max_pixels);
  if (is_webp(bytes)) return decode_webp(bytes, name, max_pixels);
  refuse_content(name);
}

bool swaps_sides(int orientation) { return orientation >= 5; }

}  // namespace

ImageSize upright(ImageSize size, int orientation) {
  return swaps_sides(orientation) ? ImageSize{size.height, size.width} : size;
}

// EXIF orientation says which corner of the scene the stored first row and column are at.
RgbImage upright(RgbImage stored, int orientation) {
  if (orientation == 1) return stored;
  const ImageSize size = upright(ImageSize{stored.width, stored.height}, orientation);
  const bool mirror_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool mirror_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  RgbImage image(size.width, size.height);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      int from_x = swaps_sides(orientation) ? y : x;
      int from_y = swaps_sides(orientation) ? x : y;
      if (mirror_x) from_x = stored.width - 1 - from_x;
      if (mirror_y) from_y = stored.height - 1 - from_y;
      image.at(x, y) = stored.at(from_x, from_y);
    }
  return image;
}

void check_size(int64_t width, int64_t height, const std::string& name) {
  if (width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide &&
      width * height <= kMaxImagePixels)
    return;
  throw std::runtime_error(name + ": " + std::to_string(width) + " x " + std::to_string(height) +
                           " pixels is outside the limits (1 to " + std::to_string(kMaxImageSide) + " a side, " +
                           std::to_string(kMaxImagePixels) + " in all)");
}

void refuse_too_large(ImageSize size, int64_t max_pixels, const std::string& name) {
  throw std::runtime_error(name + ": " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                           " pixels cannot be reduced to " + std::to_string(max_pixels) + " pixels");
}

void refuse_damaged(const std::string& name, const std::string& format, const std::string& what) {
  throw DamagedImage(name + ": damaged " + format + " (" + what + "): copy it again, or leave it out");
}

RgbImage decode_image(std::span<const uint8_t> bytes, const std::string& name) {
  return decode(bytes, name, kMaxImagePixels).image;
}

RgbImage decode_image(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels) {
  return decode(bytes, name, max_pixels).image;
}

ImageSize image_size(std::span<const uint8_t> bytes, const std::string& name) {
  if (is_jpeg(bytes)) return jpeg_size(bytes, name);
  if (is_png(bytes)) return png_size(bytes, name);
  if (is_webp(bytes)) return webp_size(bytes, name);
  refuse_content(name);
}

Photo read_photo(const std::filesystem::path& file, int64_t max_pixels, const std::string& called) {
  const std::vector<uint8_t> bytes = read_file(file);
  ScaledImage scaled = decode(bytes, called.empty() ? file.string() : called, max_pixels);
  const Exif exif = is_jpeg(bytes) ? read_exif(bytes, scaled.full_size) : Exif{};
  return {upright(std::move(scaled.image), exif.orientation), exif.focal_hint,
          upright(scaled.full_size, exif.orientation), scaled.scale};
}

RgbImage read_image(const std::filesystem::path& file) { return read_photo(file).image; }

ImageSize read_image_size(const std::filesystem::path& file, const std::string& called) {
  const MappedFile mapped(file);
  const ImageSize size = image_size(mapped.bytes(), called.empty() ? file.string() : called);
  return is_jpeg(mapped.bytes()) ? upright(size, read_exif(mapped.bytes(), size).orientation) : size;
}

std::optional<double> read_focal_hint(const std::filesystem::path& file) {
  const MappedFile mapped(file);
  if (!is_jpeg(mapped.bytes())) return std::nullopt;
  return read_exif(mapped.bytes(), image_size(mapped.bytes(), file.string())).focal_hint;
}

}  // namespace ldp
