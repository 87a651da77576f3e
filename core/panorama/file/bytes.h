// Little-endian numbers to and from bytes, the same on every architecture. Reading is checked: every refusal says which
// chunk, at which offset of the file, what was expected and what was found.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/panorama/file/ldp_file.h"

namespace ldp::file {

class ByteWriter {
 public:
  void u8(uint8_t value) { bytes.push_back(value); }
  void u16(uint16_t value) { number(value, 2); }
  void u32(uint32_t value) { number(value, 4); }
  void u64(uint64_t value) { number(value, 8); }
  void f64(double value) { u64(std::bit_cast<uint64_t>(value)); }
  void append(std::span<const uint8_t> more) { bytes.insert(bytes.end(), more.begin(), more.end()); }
  void append(std::string_view text) { bytes.insert(bytes.end(), text.begin(), text.end()); }

  std::vector<uint8_t> bytes;

 private:
  void number(uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i) & 255));
  }
};

// Words for "what and where", so that errors of one chunk all begin alike.
class Place {
 public:
  Place(std::string name, uint64_t offset) : name_(std::move(name)), offset_(offset) {}
  std::string name() const { return name_ + " at offset " + std::to_string(offset_); }
  uint64_t offset() const { return offset_; }

  [[noreturn]] void refuse(const std::string& what) const { throw LdpError(name() + ": " + what); }
  [[noreturn]] void refuse(const std::string& field, const std::string& expected, const std::string& found) const {
    refuse(field + ": expected " + expected + ", found " + found);
  }

 private:
  std::string name_;
  uint64_t offset_;
};

class ByteReader {
 public:
  ByteReader(std::span<const uint8_t> bytes, Place place) : bytes_(bytes), place_(std::move(place)) {}

  uint8_t u8() { return take(1)[0]; }
  uint16_t u16() { return static_cast<uint16_t>(number(2)); }
  uint32_t u32() { return static_cast<uint32_t>(number(4)); }
  uint64_t u64() { return number(8); }
  double f64() { return std::bit_cast<double>(u64()); }
  std::span<const uint8_t> take(size_t count) {
    if (count > left())
      place_.refuse("its length", "at least " + std::to_string(position_ + count) + " bytes",
                    std::to_string(bytes_.size()));
    const auto part = bytes_.subspan(position_, count);
    position_ += count;
    return part;
  }
  std::string text(size_t count) {
    const auto part = take(count);
    return {part.begin(), part.end()};
  }

  // Numbers within bounds. The names are those of FORMAT.md.
  int whole(const char* field, int least, int most) {
    const uint32_t value = u32();
    if (value < static_cast<uint32_t>(least) || value > static_cast<uint32_t>(most))
      place_.refuse(field, std::to_string(least) + " to " + std::to_string(most), std::to_string(value));
    return static_cast<int>(value);
  }
  uint8_t choice(const char* field, uint8_t most) {
    const uint8_t value = u8();
    if (value > most) place_.refuse(field, "0 to " + std::to_string(most), std::to_string(value));
    return value;
  }
  double finite(const char* field) {
    const double value = f64();
    if (!std::isfinite(value)) place_.refuse(field, "a finite number", "infinity or not a number");
    return value;
  }

  size_t left() const { return bytes_.size() - position_; }
  const Place& place() const { return place_; }
  void expect_end() const {
    if (left() > 0) place_.refuse("its length", std::to_string(position_) + " bytes", std::to_string(bytes_.size()));
  }

 private:
  uint64_t number(size_t count) {
    uint64_t value = 0;
    const auto part = take(count);
    for (size_t i = 0; i < count; ++i) value |= uint64_t{part[i]} << (8 * i);
    return value;
  }

  std::span<const uint8_t> bytes_;
  size_t position_ = 0;
  Place place_;
};

}  // namespace ldp::file
