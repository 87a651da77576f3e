// Any bytes as the ALPH chunk of a small strip, some of whose pixels are absent.
#include <cstddef>
#include <cstdint>

#include "core/panorama/file/coders/alpha_coding.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  ldp::Plane<uint8_t> coverage(1 + data[0] % 40, 1 + data[1] % 24, 1);
  for (size_t i = 0; i < coverage.samples.size(); i += 3) coverage.samples[i] = 0;
  try {
    ldp::file::decode_alpha_strip({data + 2, size - 2}, {"chunk", 0}, coverage);
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
