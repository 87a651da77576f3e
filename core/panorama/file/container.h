// The outer form of the file (FORMAT.md, "Container"): magic, version, table of chunks with CRC-32C, chunks.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/panorama/file/bytes.h"
#include "core/panorama/file/ldp_file.h"

namespace ldp::file {

struct NewChunk {
  std::string type;
  int layer = -1, strip = -1;
  std::vector<uint8_t> bytes;
};

std::vector<uint8_t> write_container(const std::vector<NewChunk>& chunks, int version);

struct Container {
  int version = 0;
  std::vector<LdpChunk> chunks;
};

// Checks magic, version, table and that the chunks fill the file without gap or overlap; not the chunks' contents.
Container read_container(std::span<const uint8_t> file);

Place place_of(const LdpChunk& chunk);

// The chunk's bytes, its checksum verified.
std::span<const uint8_t> checked_bytes(std::span<const uint8_t> file, const LdpChunk& chunk);

}  // namespace ldp::file
