// Opacity of the present pixels of one strip of one layer (FORMAT.md, "Opacity"), with the same range coder as depth.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/plane.h"
#include "core/panorama/file/bytes.h"

namespace ldp::file {

std::vector<uint8_t> encode_alpha_strip(const Plane<uint8_t>& coverage, const Plane<uint8_t>& alpha);

// Absent pixels get 0.
Plane<uint8_t> decode_alpha_strip(std::span<const uint8_t> bytes, const Place& place, const Plane<uint8_t>& coverage);

}  // namespace ldp::file
