// Image files: JPEG through libjpeg-turbo, PNG through libpng, WebP through libwebp, EXIF through libexif, PFM. The one
// place that includes those libraries.
//
// Errors: std::runtime_error naming the file and what is wrong with it. An image that ends early or is damaged is
// an error, not a grey area in the picture. Limits are checked before anything is allocated. Transparency is
// dropped, 16-bit samples are rounded to 8.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/plane.h"

namespace ldp {

constexpr int64_t kMaxImagePixels = int64_t{1} << 28;
constexpr int kMaxImageSide = 1 << 16;

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
// is); what is still too large is refused. scale says which.
Photo read_photo(const std::filesystem::path& file, int64_t max_pixels = kMaxImagePixels);

// Header only, EXIF orientation applied.
ImageSize read_image_size(const std::filesystem::path& file);
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
constexpr int kMaxWebpSide = 16383;
std::vector<uint8_t> encode_webp(const RgbImage& image, int quality);  // quality 1 .. 100, 4:2:0
std::vector<uint8_t> encode_webp_lossless(const RgbImage& image);
std::vector<uint8_t> encode_pfm(const Plane<float>& values);  // one channel, little-endian, rows bottom to top
Plane<float> decode_pfm(std::span<const uint8_t> bytes, const std::string& name_for_errors);

// Whole files. write_file is atomic: temporary file in the same folder, fsync, rename, fsync of the folder; throws
// std::system_error naming the path and leaves nothing behind. Devices and pipes are written to directly.
std::vector<uint8_t> read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, std::span<const uint8_t> bytes);

// Makes names in a folder last through a power cut. False where the file system knows no such thing (some of FUSE, some
// network shares): a rename is as safe there as it can be, and nothing is refused. Throws std::system_error.
bool sync_folder(const std::filesystem::path& folder);

// What write_file does, step by step: a file under a temporary name beside its own, gone again unless it is finished.
// All throw as write_file does.
class PartialFile {
 public:
  explicit PartialFile(const std::filesystem::path& target);  // makes nothing yet; a link stays a link
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  const std::filesystem::path& path() const { return path_; }  // the temporary one
  void write(std::span<const uint8_t> bytes);                  // all of it, once, and flushes it
  void finish();                                               // gives it its name for good

 private:
  std::filesystem::path target_, path_;
  bool begun_ = false;
};

// A file's bytes without reading it as a whole. The file must not be cut short while it is mapped.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& file);  // throws std::system_error naming the path
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::span<const uint8_t> bytes() const { return {data_, size_}; }

 private:
  const uint8_t* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace ldp
