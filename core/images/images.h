// Image files: JPEG through libjpeg-turbo, PNG through libpng, PFM. The one place that includes those libraries.
//
// Errors: std::runtime_error naming the file and what is wrong with it. Limits: kMaxImagePixels is checked before
// anything is allocated. EXIF orientation is applied on reading.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plane.h"

namespace ldp {

constexpr int64_t kMaxImagePixels = int64_t{1} << 28;
constexpr int kMaxImageSide = 1 << 16;

struct Photo {
  RgbImage image;
  std::optional<double> focal_hint;  // focal length / longer side, from EXIF
};

struct ImageSize {
  int width = 0, height = 0;
};

RgbImage read_image(const std::filesystem::path& file);   // .jpg .jpeg .png, by content
Photo read_photo(const std::filesystem::path& file);      // with EXIF orientation and focal length
ImageSize read_image_size(const std::filesystem::path& file);  // header only, orientation applied

RgbImage decode_image(std::span<const uint8_t> bytes, const std::string& name_for_errors);
std::vector<uint8_t> encode_jpeg(const RgbImage& image, int quality);  // 4:2:0 below quality 90, 4:4:4 from 90
std::vector<uint8_t> encode_png(const RgbImage& image);
std::vector<uint8_t> encode_png(const RgbImage& image, const Plane<uint8_t>& alpha);
std::vector<uint8_t> encode_png(const Plane<uint8_t>& grey);
std::vector<uint8_t> encode_png(const Plane<uint16_t>& grey);
std::vector<uint8_t> encode_pfm(const Plane<float>& values);           // one channel, little-endian, rows bottom to top
Plane<float> decode_pfm(std::span<const uint8_t> bytes, const std::string& name_for_errors);

// Whole files. write_file is atomic: temporary file in the same folder, fsync, rename, fsync of the folder; throws
// std::system_error naming the path and leaves nothing behind.
std::vector<uint8_t> read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, std::span<const uint8_t> bytes);

}  // namespace ldp
