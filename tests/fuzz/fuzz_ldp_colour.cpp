// Any bytes as the COLR chunk of a small strip, some of whose pixels are absent.
#include <cstddef>
#include <cstdint>

#include "core/panorama/file/coders/colour_coding.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 3) return 0;
  ldp::file::DepthStrip strip;
  strip.coverage = {1 + data[0] % 40, 1 + data[1] % 24, uint8_t{1}};
  for (size_t i = data[2]; i < strip.coverage.samples.size(); i += 1 + data[2] % 3) strip.coverage.samples[i] = 0;
  strip.tiles = ldp::file::tile_states(strip.coverage);
  try {
    ldp::file::decode_colour_strip({data + 3, size - 3}, {"chunk", 0}, strip, ldp::kLdpVersion);
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
