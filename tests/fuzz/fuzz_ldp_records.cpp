// Any bytes as one of the small chunks.
#include <cstddef>
#include <cstdint>

#include "core/panorama/file/records.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const ldp::file::ByteReader reader({data + 1, size - 1}, {"chunk", 0});
  ldp::PanoramaGrid grid;
  grid.width = grid.height = 100;
  try {
    switch (data[0] % 6) {
      case 0:
        ldp::file::read_head(reader, {});
        break;
      case 1:
        ldp::file::read_layer_record(reader, grid);
        break;
      case 2:
        ldp::file::read_cameras(reader);
        break;
      case 3:
        ldp::file::read_quality(reader);
        break;
      case 4:
        ldp::file::read_exposure(reader, grid);
        break;
      default:
        ldp::file::read_metadata(reader);
        break;
    }
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
