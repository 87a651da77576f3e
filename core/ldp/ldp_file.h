// The .ldp file (format: FORMAT.md in this folder): encoding, decoding, describing and verifying.
//
// Errors: LdpError, whose message names the chunk, its offset, what was expected and what was found. Every limit is
// checked before allocation. decode(encode(p)) returns depth codes, coverage and alpha exactly; colour as the codec keeps it.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "panorama.h"

namespace ldp {

struct LdpError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct LdpEncodeOptions {
  int colour_quality = 90;  // 1 .. 100; 101 = lossless
};

struct LdpChunk {
  std::string type;  // four characters
  int layer = -1;    // -1 = belongs to the whole file
  uint64_t offset = 0, length = 0;
  uint32_t crc32c = 0;
};

struct LdpDescription {
  int version = 0;
  uint64_t file_bytes = 0;
  std::vector<LdpChunk> chunks;
};

std::vector<uint8_t> encode_ldp(const LayeredPanorama& panorama, const LdpEncodeOptions& options);
LayeredPanorama decode_ldp(std::span<const uint8_t> bytes);
LdpDescription describe_ldp(std::span<const uint8_t> bytes);            // header and chunk table only
std::vector<std::string> verify_ldp(std::span<const uint8_t> bytes);    // every damage found, one line each; empty = sound

}  // namespace ldp
