// Any bytes as what stands in a JPEG's EXIF segment.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "core/photos/codecs/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const size_t length = std::min<size_t>(size, 0xFFFF - 8) + 8;
  std::vector<uint8_t> jpeg = {0xFF, 0xD8, 0xFF, 0xE1, static_cast<uint8_t>(length >> 8), static_cast<uint8_t>(length)};
  for (const char c : {'E', 'x', 'i', 'f', '\0', '\0'}) jpeg.push_back(static_cast<uint8_t>(c));
  jpeg.insert(jpeg.end(), data, data + length - 8);
  const ldp::Exif exif = ldp::read_exif(jpeg, {640, 480});
  if (exif.orientation < 1 || exif.orientation > 8) std::abort();
  if (exif.focal_hint && !(*exif.focal_hint >= 0.2 && *exif.focal_hint <= 20)) std::abort();
  return 0;
}
