// Any bytes as a photo: JPEG, PNG and WebP by content, whole and as a thumbnail, the size alone, a PNG's words, PFM.
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

#include "core/photos/images.h"

namespace {

template <typename Read>
void attempt(const Read& read) {
  try {
    read();
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const uint8_t> bytes(data, size);
  ldp::ImageSize stored;
  attempt([&] { stored = ldp::image_size(bytes, "photo"); });
  attempt([&] { ldp::png_software(bytes); });
  attempt([&] { ldp::decode_pfm(bytes, "photo"); });
  if (int64_t{stored.width} * stored.height > 1 << 18) return 0;  // sound sizes beyond that only take time
  attempt([&] { ldp::decode_image(bytes, "photo"); });
  attempt([&] { ldp::decode_image(bytes, "photo", 1 << 8); });
  return 0;
}
