// What may stand in XML, HTML, on terminals and where text is UTF-8: any text, and any bytes that the name of a file
// may hold.
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

// For a terminal: control characters, and bytes of no character, as \x1b; other text as it is. Names of files hold any.
std::string printable(std::string_view text);

std::string base64(std::span<const uint8_t> bytes);

// For what a script of HTML holds: Ascii85 as of PDF (ISO 32000-1, 7.4.3; four bytes are five characters) without "z"
// and the end's mark, and "v" instead of "<".
std::string base85(std::span<const uint8_t> bytes);

}  // namespace ldp
