// What may stand in XML and HTML: any text, any bytes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace ldp {

// In text or between double quotes: & < " by name, control characters left out.
std::string escaped(std::string_view text);

std::string base64(std::span<const uint8_t> bytes);

}  // namespace ldp
