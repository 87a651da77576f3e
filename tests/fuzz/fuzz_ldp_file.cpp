// Any bytes as an .ldp file, its checksums made right so that what lies behind them is reached.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "crc32c.h"
#include "ldp_file.h"

namespace {

uint64_t number(const std::vector<uint8_t>& file, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = 0; i < count; ++i) value |= uint64_t{file[at + i]} << (8 * i);
  return value;
}

void put(std::vector<uint8_t>& file, size_t at, uint64_t value, size_t count) {
  for (size_t i = 0; i < count; ++i) file[at + i] = static_cast<uint8_t>(value >> (8 * i) & 255);
}

void seal(std::vector<uint8_t>& file) {
  if (file.size() < 32) return;
  const uint64_t count = number(file, 12, 4);
  put(file, 16, file.size(), 8);
  if (count > (file.size() - 32) / 32) return;
  const std::span<const uint8_t> all(file);
  for (size_t i = 0; i < count; ++i) {
    const size_t entry = 32 + 32 * i;
    const uint64_t offset = number(file, entry + 8, 8);
    const uint64_t length = number(file, entry + 16, 8);
    if (offset > file.size() || length > file.size() - offset) continue;
    put(file, entry + 24, ldp::crc32c(all.subspan(static_cast<size_t>(offset), static_cast<size_t>(length))), 4);
  }
  put(file, 24, ldp::crc32c(all.subspan(32, 32 * static_cast<size_t>(count))), 4);
  put(file, 28, ldp::crc32c(all.first(28)), 4);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::vector<uint8_t> file(data, data + size);
  seal(file);
  try {
    ldp::decode_ldp(file, {1 << 16});
  } catch (const ldp::LdpError&) {
  }
  return 0;
}
