// Any bytes as the file of a script: button.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "device/backends/open.h"
#include "tests/fuzz/scratch_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const ldp::ScratchFolder folder;
  try {
    ldp::open_button("script:" + folder.store("script", data, size).string())->read();
  } catch (const std::runtime_error&) {
  }
  return 0;
}
