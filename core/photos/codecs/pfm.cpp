#include <array>
#include <bit>
#include <charconv>
#include <stdexcept>
#include <string_view>

#include "core/photos/codecs/formats.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw std::runtime_error(name + ": damaged PFM: " + what);
}

// The header's next word; leaves `position` behind the one white space that ends it.
std::string_view next_word(std::span<const uint8_t> bytes, size_t& position) {
  const auto is_space = [&](size_t i) {
    return bytes[i] == ' ' || bytes[i] == '\n' || bytes[i] == '\r' || bytes[i] == '\t';
  };
  while (position < bytes.size() && is_space(position)) ++position;
  const size_t begin = position;
  while (position < bytes.size() && !is_space(position)) ++position;
  const std::string_view word(reinterpret_cast<const char*>(bytes.data()) + begin, position - begin);
  ++position;
  return word;
}

template <typename T>
T number(std::string_view word, const std::string& name) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) fail(name, "a number in the header cannot be read");
  return value;
}

float float_from(const uint8_t* bytes, bool little) {
  uint32_t bits = 0;
  for (int i = 0; i < 4; ++i) bits |= uint32_t{bytes[i]} << (little ? 8 * i : 24 - 8 * i);
  return std::bit_cast<float>(bits);
}

}  // namespace

std::vector<uint8_t> encode_pfm(const Plane<float>& values) {
  const std::string header = "Pf\n" + std::to_string(values.width) + " " + std::to_string(values.height) + "\n-1.0\n";
  std::vector<uint8_t> out(header.begin(), header.end());
  out.reserve(header.size() + values.samples.size() * 4);
  for (int y = values.height - 1; y >= 0; --y)
    for (int x = 0; x < values.width; ++x) {
      const auto bits = std::bit_cast<uint32_t>(values.at(x, y));
      for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(bits >> (8 * i) & 255));
    }
  return out;
}

Plane<float> decode_pfm(std::span<const uint8_t> bytes, const std::string& name) {
  size_t position = 0;
  if (next_word(bytes, position) != "Pf") fail(name, "expected a header 'Pf' (one channel)");
  const auto width = number<int64_t>(next_word(bytes, position), name);
  const auto height = number<int64_t>(next_word(bytes, position), name);
  const bool little = next_word(bytes, position).starts_with('-');
  check_size(width, height, name);
  const auto expected = static_cast<uint64_t>(width * height) * 4;
  if (position > bytes.size() || bytes.size() - position < expected)
    fail(name, "the file ends too early: expected " + std::to_string(expected) + " bytes of samples");
  Plane<float> values(static_cast<int>(width), static_cast<int>(height));
  for (int y = values.height - 1; y >= 0; --y)
    for (int x = 0; x < values.width; ++x, position += 4) values.at(x, y) = float_from(&bytes[position], little);
  return values;
}

}  // namespace ldp
