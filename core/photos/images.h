// Image files: JPEG through libjpeg-turbo, PNG through libpng, WebP through libwebp, EXIF through libexif, PFM. The one
// place that includes those libraries.
//
// Errors: std::runtime_error naming the file and what is wrong with it. An image that ends early or is damaged is
// an error (DamagedImage), not a grey area in the picture. Limits are checked before anything is allocated.
// Transparency is dropped, 16-bit samples are rounded to 8.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/plane.h"

namespace ldp {

constexpr int64_t kMaxImagePixels = int64_t{1} << 28;
constexpr int kMaxImageSide = 1 << 16;

struct DamagedImage : std::runtime_error {  // or no image at all
  using std::runtime_error::runtime_error;
};

struct ImageSize {
  int width = 0, height = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

struct Photo {
  RgbImage image;                    // upright: EXIF orientation applied
  std::optional<double> focal_hint;  // focal length / longer side, from EXIF
  ImageSize full_size;               // upright size of the stored image
  double scale = 1;                  // image pixels per stored pixel: an image position times 1 / scale is a stored one
};

// EXIF's orientations, 1 to 8: 1 is upright as stored, 6, 3 and 8 are upright after a turn by 90, 180 and 270 degrees
// clockwise.
ImageSize upright(ImageSize stored, int orientation);
RgbImage upright(RgbImage stored, int orientation);

// By content: JPEG, PNG or WebP. EXIF orientation applied.
RgbImage read_image(const std::filesystem::path& file);

// With at most max_pixels pixels, so that a 40-megapixel photo can be worked on in little memory: JPEG is decoded at
// the largest of 8/8, 7/8 ... 1/8 of its size that fits, PNG averaged over the smallest squares that fit (WebP as it
// is); what is still too large is refused. scale says which. called: its name in refusals of what is in it; empty = its
// path.
Photo read_photo(const std::filesystem::path& file, int64_t max_pixels = kMaxImagePixels,
                 const std::string& called = {});

// Header only, EXIF orientation applied.
ImageSize read_image_size(const std::filesystem::path& file, const std::string& called = {});
std::optional<double> read_focal_hint(const std::filesystem::path& file);  // that of read_photo

// From memory. EXIF orientation is not applied.
RgbImage decode_image(std::span<const uint8_t> bytes, const std::string& name_for_errors);
// Shrunk as by read_photo to at most max_pixels: a JPEG's thumbnail in a millisecond or two.
RgbImage decode_image(std::span<const uint8_t> bytes, const std::string& name_for_errors, int64_t max_pixels);
ImageSize image_size(std::span<const uint8_t> bytes, const std::string& name_for_errors);

// An application segment of a JPEG file: marker 0xE0 .. 0xEF or 0xFE, up to 65533 bytes.
struct JpegSegment {
  uint8_t marker = 0;
  std::vector<uint8_t> bytes;
};

std::vector<uint8_t> encode_jpeg(const RgbImage& image, int quality);  // 4:2:0 below quality 90, 4:4:4 from 90
std::vector<uint8_t> encode_jpeg(const RgbImage& image, int quality, std::span<const JpegSegment> segments);
std::vector<uint8_t> encode_jpeg_444(const RgbImage& image, int quality);  // full resolution of colour at any quality
std::vector<uint8_t> encode_png(const RgbImage& image);
std::vector<uint8_t> encode_png(const RgbImage& image, const std::string& xmp);  // with a packet of metadata
std::vector<uint8_t> encode_png(const RgbImage& image, const Plane<uint8_t>& alpha);
std::vector<uint8_t> encode_png(const RgbImage& image, const Plane<uint8_t>& alpha, const std::string& software);
std::string png_software(std::span<const uint8_t> bytes);  // as told before the pixels; empty = not, or no sound PNG
std::vector<uint8_t> encode_png(const Plane<uint8_t>& grey);
std::vector<uint8_t> encode_png(const Plane<uint16_t>& grey);
std::vector<uint8_t> encode_png(const Plane<uint16_t>& grey, const std::string& xmp);
constexpr int kMaxWebpSide = 16383;
std::vector<uint8_t> encode_webp(const RgbImage& image, int quality);  // quality 1 .. 100, 4:2:0
std::vector<uint8_t> encode_webp_lossless(const RgbImage& image);
std::vector<uint8_t> encode_pfm(const Plane<float>& values);  // one channel, little-endian, rows bottom to top
Plane<float> decode_pfm(std::span<const uint8_t> bytes, const std::string& name_for_errors);

}  // namespace ldp
