#include <webp/decode.h>
#include <webp/encode.h>

#include <cstring>
#include <stdexcept>

#include "core/photos/codecs/formats.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

WebPBitstreamFeatures features_of(std::span<const uint8_t> bytes, const std::string& name) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes.data(), bytes.size(), &features) != VP8_STATUS_OK)
    refuse_damaged(name, "WebP", "its header cannot be read");
  if (features.has_animation) throw std::runtime_error(name + ": an animated WebP is not a photo");
  check_size(features.width, features.height, name);
  return features;
}

WebPConfig plain_config() {
  WebPConfig config;
  if (!WebPConfigInit(&config)) throw std::logic_error("libwebp's headers and library differ in version");
  config.thread_level = 0;
  return config;
}

std::vector<uint8_t> encode(const RgbImage& image, const WebPConfig& config) {
  WebPPicture picture;
  WebPMemoryWriter writer;
  if (!WebPPictureInit(&picture)) throw std::logic_error("libwebp's headers and library differ in version");
  WebPMemoryWriterInit(&writer);
  picture.use_argb = config.lossless;
  picture.width = image.width;
  picture.height = image.height;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const auto* samples = reinterpret_cast<const uint8_t*>(image.samples.data());
  const bool done = WebPPictureImportRGB(&picture, samples, image.width * 3) && WebPEncode(&config, &picture);
  const int error = picture.error_code;
  std::vector<uint8_t> bytes;
  if (done) bytes.assign(writer.mem, writer.mem + writer.size);
  WebPPictureFree(&picture);
  WebPMemoryWriterClear(&writer);
  if (!done) throw std::runtime_error("cannot write WebP: libwebp's error " + std::to_string(error));
  return bytes;
}

void check_sides(const RgbImage& image) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxWebpSide || image.height > kMaxWebpSide)
    throw std::logic_error("a WebP image has 1 to " + std::to_string(kMaxWebpSide) + " pixels a side");
}

}  // namespace

bool is_webp(std::span<const uint8_t> bytes) {
  return bytes.size() >= 12 && std::memcmp(bytes.data(), "RIFF", 4) == 0 &&
         std::memcmp(bytes.data() + 8, "WEBP", 4) == 0;
}

ImageSize webp_size(std::span<const uint8_t> bytes, const std::string& name) {
  const WebPBitstreamFeatures features = features_of(bytes, name);
  return {features.width, features.height};
}

ScaledImage decode_webp(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels) {
  const WebPBitstreamFeatures features = features_of(bytes, name);
  const ImageSize size{features.width, features.height};
  if (int64_t{size.width} * size.height > max_pixels) refuse_too_large(size, max_pixels, name);
  RgbImage image(size.width, size.height);
  auto* samples = reinterpret_cast<uint8_t*>(image.samples.data());
  if (!WebPDecodeRGBInto(bytes.data(), bytes.size(), samples, image.samples.size() * 3, image.width * 3))
    refuse_damaged(name, "WebP", "its pixels cannot be read");
  return {std::move(image), size, 1};
}

std::vector<uint8_t> encode_webp(const RgbImage& image, int quality) {
  if (quality < 1 || quality > 100)
    throw std::logic_error("WebP quality must be 1 to 100, not " + std::to_string(quality));
  check_sides(image);
  WebPConfig config = plain_config();
  config.quality = static_cast<float>(quality);
  config.method = 3;
  return encode(image, config);
}

std::vector<uint8_t> encode_webp_lossless(const RgbImage& image) {
  check_sides(image);
  WebPConfig config = plain_config();
  config.lossless = 1;
  config.exact = 1;
  config.quality = 30;
  config.method = 2;
  return encode(image, config);
}

}  // namespace ldp
