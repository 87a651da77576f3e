#include "core/base/markup_text.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace ldp {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

// What the first byte of a character tells: its bytes, and the range of the second one, which leaves out longer forms
// of shorter characters, halves of surrogate pairs, and what is beyond U+10FFFF. length = 0: no character begins so.
struct Beginning {
  size_t length = 0;
  uint8_t low = 0x80, high = 0xBF;
};

Beginning beginning(uint8_t first) {
  if (first < 0x80) return {1};
  if (first < 0xC2 || first > 0xF4) return {};
  if (first < 0xE0) return {2};
  if (first < 0xF0) return {3, uint8_t(first == 0xE0 ? 0xA0 : 0x80), uint8_t(first == 0xED ? 0x9F : 0xBF)};
  return {4, uint8_t(first == 0xF0 ? 0x90 : 0x80), uint8_t(first == 0xF4 ? 0x8F : 0xBF)};
}

// Bytes of the character that the text begins with, as far as it goes on.
size_t sound_bytes(std::string_view text, Beginning of) {
  size_t sound = 1;
  for (; sound < of.length && sound < text.size(); of.low = 0x80, of.high = 0xBF, ++sound) {
    const auto byte = static_cast<uint8_t>(text[sound]);
    if (byte < of.low || byte > of.high) break;
  }
  return sound;
}

}  // namespace

std::string utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const Beginning of = beginning(static_cast<uint8_t>(text[0]));
    const size_t sound = sound_bytes(text, of);
    out += sound == of.length ? text.substr(0, sound) : kReplacement;
    text.remove_prefix(sound);
  }
  return out;
}

std::string printable(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  while (!text.empty()) {
    const Beginning of = beginning(static_cast<uint8_t>(text[0]));
    const size_t sound = sound_bytes(text, of);
    const bool is_control = of.length == 1 ? static_cast<uint8_t>(text[0]) < 0x20 || text[0] == 0x7F
                                           : text[0] == '\xC2' && sound == 2 && static_cast<uint8_t>(text[1]) < 0xA0;
    for (const char c : text.substr(0, sound)) {
      if (is_control || sound != of.length)
        out.append("\\x").append(1, kDigits[static_cast<uint8_t>(c) >> 4]).append(1, kDigits[c & 15]);
      else
        out += c;
    }
    text.remove_prefix(sound);
  }
  return out;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 32)
      out += c;
  }
  return out;
}

std::string base64(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string base85(std::span<const uint8_t> bytes) {
  constexpr size_t kBytes = 4, kDigits = 5;
  std::string text;
  text.reserve((bytes.size() + kBytes - 1) / kBytes * kDigits);
  for (size_t i = 0; i < bytes.size(); i += kBytes) {
    const size_t here = std::min(kBytes, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < kBytes; ++k) group = group << 8 | (k < here ? bytes[i + k] : 0);
    std::array<char, kDigits> digits{};
    for (size_t k = kDigits; k-- > 0; group /= 85) digits[k] = static_cast<char>('!' + group % 85);
    std::replace(digits.begin(), digits.end(), '<', 'v');
    text.append(digits.data(), here + 1);
  }
  return text;
}

}  // namespace ldp
