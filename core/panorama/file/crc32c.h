// CRC-32C (Castagnoli): reflected polynomial 0x82F63B78, start and final exclusive-or 0xFFFFFFFF.
#pragma once

#include <cstdint>
#include <span>

namespace ldp::file {

uint32_t crc32c(std::span<const uint8_t> bytes);

}  // namespace ldp::file
