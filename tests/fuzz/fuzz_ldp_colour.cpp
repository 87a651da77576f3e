// Any bytes as the COLR chunk of a small strip.
#include <cstddef>
#include <cstdint>

#include "colour_coding.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  ldp::DepthStrip strip;
  strip.coverage = {1 + data[0] % 40, 1 + data[1] % 24, uint8_t{1}};
  strip.tiles = ldp::tile_states(strip.coverage);
  try {
    ldp::decode_colour_strip({data + 2, size - 2}, {"chunk", 0}, strip);
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
