// Makes the length and the checksums of a damaged .ldp file right again, as a careful forger would, so that tests reach
// what lies behind them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/panorama/file/crc32c.h"

namespace ldp {

inline void seal(std::vector<uint8_t>& file) {
  constexpr size_t kHeader = 32, kEntry = 32;
  if (file.size() < kHeader) return;
  const auto number = [&](size_t at, size_t count) {
    uint64_t value = 0;
    for (size_t i = 0; i < count; ++i) value |= uint64_t{file[at + i]} << (8 * i);
    return value;
  };
  const auto put = [&](size_t at, uint64_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) file[at + i] = static_cast<uint8_t>(value >> (8 * i) & 255);
  };
  const std::span<const uint8_t> all(file);
  const uint64_t entries = number(12, 4);
  put(16, file.size(), 8);
  if (entries <= (file.size() - kHeader) / kEntry) {
    for (size_t i = 0; i < entries; ++i) {
      const uint64_t offset = number(kHeader + kEntry * i + 8, 8);
      const uint64_t length = number(kHeader + kEntry * i + 16, 8);
      if (offset > file.size() || length > file.size() - offset) continue;
      put(kHeader + kEntry * i + 24,
          file::crc32c(all.subspan(static_cast<size_t>(offset), static_cast<size_t>(length))), 4);
    }
    put(24, file::crc32c(all.subspan(kHeader, kEntry * static_cast<size_t>(entries))), 4);
  }
  put(28, file::crc32c(all.first(28)), 4);
}

}  // namespace ldp
