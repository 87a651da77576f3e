// What may stand in XML, HTML and where text is UTF-8: any text, and any bytes that the name of a file may hold.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace ldp {

// In text or between double quotes: & < " by name, control characters left out.
std::string escaped(std::string_view text);

// Each longest beginning of a character that goes no further, and each byte that begins none, becomes U+FFFD.
std::string utf8(std::string_view text);

std::string base64(std::span<const uint8_t> bytes);

}  // namespace ldp
