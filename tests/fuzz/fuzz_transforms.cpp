// Any text as a transforms.json; what is accepted must be cameras that can be worked with.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "core/captures/transforms.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    for (const ldp::Camera& camera : ldp::parse_transforms({reinterpret_cast<const char*>(data), size}, "transforms")) {
      const ldp::Intrinsics& k = camera.intrinsics;
      if (k.width < 1 || k.height < 1 || !(k.fx > 0) || !(k.fy > 0)) std::abort();
      if (!camera.pose.centre.allFinite()) std::abort();
    }
  } catch (const std::runtime_error&) {
  }
  return 0;
}
