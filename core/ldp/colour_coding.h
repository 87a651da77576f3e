// Colour of one strip of one layer (FORMAT.md, "Colour"): the tiles that have any present pixel, packed row by row into
// an image of an existing codec. What is absent is filled so that it costs little.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bytes.h"
#include "depth_coding.h"
#include "ldp_file.h"
#include "plane.h"

namespace ldp {

std::vector<uint8_t> encode_colour_strip(const DepthStrip& strip, const RgbImage& colour,
                                         const LdpEncodeOptions& options);

// Absent pixels get {0, 0, 0}.
RgbImage decode_colour_strip(std::span<const uint8_t> bytes, const Place& place, const DepthStrip& strip);

}  // namespace ldp
