// Any bytes as the DPTH chunk of a small strip.
#include <cstddef>
#include <cstdint>

#include "core/panorama/file/coders/depth_coding.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 3) return 0;
  ldp::file::DepthStrip strip;
  const int width = 1 + data[0] % 40;
  const int height = 1 + data[1] % 24;
  strip.block_px = data[2] % 20;
  const auto blocks = [&](int pixels) {
    return strip.block_px == 0 ? 1 : (pixels + strip.block_px - 1) / strip.block_px;
  };
  strip.ranges = {blocks(width), blocks(height), strip.block_px == 0 ? ldp::BlockRange{0, 255} : ldp::BlockRange{0, 0}};
  strip.tiles = {(width + 15) / 16, (height + 15) / 16};
  strip.coverage = {width, height};
  strip.codes = {width, height};
  try {
    ldp::file::decode_depth_strip({data + 3, size - 3}, {"chunk", 0}, strip);
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
