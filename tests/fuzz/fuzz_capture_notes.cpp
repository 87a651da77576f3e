// Any bytes as a capture.json.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

#include "core/captures/folder_frames.h"
#include "tests/fuzz/scratch_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const ldp::ScratchFolder folder;
  folder.store("capture.json", data, size);
  try {
    const ldp::CaptureNotes notes = ldp::read_capture_notes(folder.path());
    if (notes.arm_length && !(*notes.arm_length > 0)) std::abort();
    if (notes.fov_rad && !(*notes.fov_rad > 0 && *notes.fov_rad < 3)) std::abort();
  } catch (const std::runtime_error&) {
  }
  return 0;
}
