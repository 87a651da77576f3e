#include "core/panorama/file/container.h"

#include <array>
#include <cstdio>
#include <cstring>

#include "core/panorama/file/crc32c.h"

namespace ldp::file {
namespace {

// As PNG and KTX: a byte beyond ASCII, the name, both line ends and ^Z show at once what transfers do to binary files.
constexpr std::array<uint8_t, 8> kMagic = {0xAB, 'L', 'D', 'P', 0x0D, 0x0A, 0x1A, 0x0A};
constexpr size_t kHeaderBytes = 32;
constexpr size_t kEntryBytes = 32;
constexpr uint16_t kNone = 0xFFFF;
constexpr int kMaxChunks = 1 << 20;

uint16_t index_or_none(int index) { return index < 0 ? kNone : static_cast<uint16_t>(index); }
int index_from(uint16_t stored) { return stored == kNone ? -1 : stored; }

std::string hex(uint32_t value) {
  std::array<char, 11> text{};
  std::snprintf(text.data(), text.size(), "0x%08X", static_cast<unsigned>(value));
  return text.data();
}

void check_magic(std::span<const uint8_t> file, const Place& place) {
  const size_t length = std::min(file.size(), kMagic.size());
  if (length == kMagic.size() && std::memcmp(file.data(), kMagic.data(), length) == 0) return;
  if (begins_as_ldp(file))
    place.refuse("the file was changed on its way: it must be transferred as binary, not as text");
  place.refuse("not an .ldp file");
}

bool is_type(std::string_view type) {
  for (const char c : type)
    if (!((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))) return false;
  return true;
}

LdpChunk read_entry(ByteReader& table, uint64_t offset, uint64_t file_bytes) {
  LdpChunk chunk;
  chunk.type = table.text(4);
  chunk.layer = index_from(table.u16());
  chunk.strip = index_from(table.u16());
  chunk.offset = table.u64();
  chunk.length = table.u64();
  chunk.crc32c = table.u32();
  const uint32_t reserved = table.u32();
  if (!is_type(chunk.type)) table.place().refuse("chunk type", "four letters", "other bytes");
  const Place place = place_of(chunk);
  if (chunk.offset != offset)
    place.refuse("its offset in the table", std::to_string(offset), std::to_string(chunk.offset));
  if (chunk.length > file_bytes - offset)
    place.refuse("its end", "within the file's " + std::to_string(file_bytes) + " bytes",
                 "a length of " + std::to_string(chunk.length));
  if (reserved != 0) place.refuse("reserved field of the table", "0", std::to_string(reserved));
  return chunk;
}

}  // namespace

Place place_of(const LdpChunk& chunk) {
  std::string name = "chunk " + chunk.type;
  if (chunk.layer >= 0) name += " of layer " + std::to_string(chunk.layer + 1);
  if (chunk.strip >= 0) name += ", strip " + std::to_string(chunk.strip + 1);
  return {name, chunk.offset};
}

std::vector<uint8_t> write_container(const std::vector<NewChunk>& chunks, int version) {
  uint64_t offset = kHeaderBytes + kEntryBytes * chunks.size();
  ByteWriter table;
  for (const NewChunk& chunk : chunks) {
    table.append(chunk.type);
    table.u16(index_or_none(chunk.layer));
    table.u16(index_or_none(chunk.strip));
    table.u64(offset);
    table.u64(chunk.bytes.size());
    table.u32(crc32c(chunk.bytes));
    table.u32(0);
    offset += chunk.bytes.size();
  }
  ByteWriter file;
  file.bytes.reserve(static_cast<size_t>(offset));  // all of it is in memory already
  file.append(kMagic);
  file.u32(static_cast<uint32_t>(version));
  file.u32(static_cast<uint32_t>(chunks.size()));
  file.u64(offset);
  file.u32(crc32c(table.bytes));
  file.u32(crc32c(file.bytes));
  file.append(table.bytes);
  for (const NewChunk& chunk : chunks) file.append(chunk.bytes);
  return std::move(file.bytes);
}

Container read_container(std::span<const uint8_t> file) {
  const Place place("header", 0);
  check_magic(file, place);
  ByteReader header(file.first(std::min(file.size(), kHeaderBytes)), place);
  header.take(kMagic.size());
  const uint32_t version = header.u32();
  const uint32_t count = header.u32();
  const uint64_t length = header.u64();
  const uint32_t table_crc = header.u32();
  const uint32_t header_crc = header.u32();
  const uint32_t found_crc = crc32c(file.first(kHeaderBytes - 4));
  if (header_crc != found_crc) place.refuse("checksum", hex(header_crc), hex(found_crc));
  if (version < 1 || version > kLdpVersion)
    place.refuse("version", "1 to " + std::to_string(kLdpVersion),
                 std::to_string(version) + " (a newer program may read it)");
  if (length != file.size())
    place.refuse("length of the file", std::to_string(length) + " bytes", std::to_string(file.size()));
  if (count < 1 || count > kMaxChunks || count > (file.size() - kHeaderBytes) / kEntryBytes)
    place.refuse("number of chunks",
                 "1 to " + std::to_string(std::min<uint64_t>(kMaxChunks, (file.size() - kHeaderBytes) / kEntryBytes)),
                 std::to_string(count));
  const auto table_bytes = file.subspan(kHeaderBytes, kEntryBytes * count);
  const Place table_place("table of chunks", kHeaderBytes);
  if (crc32c(table_bytes) != table_crc) table_place.refuse("checksum", hex(table_crc), hex(crc32c(table_bytes)));
  ByteReader table(table_bytes, table_place);
  Container container{static_cast<int>(version), {}};
  std::vector<LdpChunk>& chunks = container.chunks;
  uint64_t offset = kHeaderBytes + table_bytes.size();
  for (uint32_t i = 0; i < count; ++i) {
    chunks.push_back(read_entry(table, offset, file.size()));
    offset += chunks.back().length;
  }
  if (offset != file.size())
    place_of(chunks.back()).refuse("end of the last chunk", std::to_string(file.size()), std::to_string(offset));
  return container;
}

std::span<const uint8_t> checked_bytes(std::span<const uint8_t> file, const LdpChunk& chunk) {
  const auto bytes = file.subspan(static_cast<size_t>(chunk.offset), static_cast<size_t>(chunk.length));
  const uint32_t found = crc32c(bytes);
  if (found != chunk.crc32c) place_of(chunk).refuse("checksum", hex(chunk.crc32c), hex(found));
  return bytes;
}

}  // namespace ldp::file

namespace ldp {

bool begins_as_ldp(std::span<const uint8_t> bytes) {
  return bytes.size() >= 4 && std::memcmp(bytes.data(), file::kMagic.data(), 4) == 0;
}

}  // namespace ldp
