// Any text as the URL of a camera, a button and a status channel.
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "device/backends/open.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string url(reinterpret_cast<const char*>(data), size);
  for (auto* check : {ldp::check_camera, ldp::check_button, ldp::check_status}) {
    try {
      check(url);
    } catch (const std::runtime_error&) {
    }
  }
  return 0;
}
