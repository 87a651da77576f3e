// Any bytes as a COLMAP model, text and binary, its lenses up to the first byte 0xFF; what is accepted must be cameras
// that can be worked with.
#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "core/captures/colmap_model.h"

namespace {

std::string_view text_of(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <typename Parse>
void parsed(const Parse& parse) {
  try {
    for (const ldp::Camera& camera : parse()) {
      const ldp::Intrinsics& k = camera.intrinsics;
      if (k.width < 1 || k.height < 1 || !(k.fx > 0) || !(k.fy > 0)) std::abort();
      if (!(camera.pose.world_from_camera.determinant() > 0.99)) std::abort();
    }
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const uint8_t> all(data, size);
  const auto cut = static_cast<size_t>(std::find(all.begin(), all.end(), uint8_t{0xFF}) - all.begin());
  const auto lenses = all.first(cut), images = all.subspan(std::min(cut + 1, size));
  parsed([&] { return ldp::parse_colmap_text(text_of(lenses), text_of(images)); });
  parsed([&] { return ldp::parse_colmap_binary(lenses, images); });
  return 0;
}
