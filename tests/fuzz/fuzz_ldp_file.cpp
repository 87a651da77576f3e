// Any bytes as an .ldp file, its checksums made right so that what lies behind them is reached.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/panorama/file/ldp_file.h"
#include "tests/golden/sealed_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::vector<uint8_t> file(data, data + size);
  ldp::seal(file);
  try {
    ldp::decode_ldp(file, {1 << 16});
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
