// Colour of one strip of one layer (FORMAT.md, section 7): its present pixels packed into an image of an existing
// codec. What is absent is filled so that it costs little.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/plane.h"
#include "core/panorama/file/bytes.h"
#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/ldp_file.h"

namespace ldp::file {

enum class ColourCodec : uint8_t { none = 0, jpeg = 1, webp = 2, jpeg_gathered = 3, webp_gathered = 4 };

std::vector<uint8_t> encode_colour_strip(const DepthStrip& strip, const RgbImage& colour,
                                         const LdpEncodeOptions& options);

// The first version of the format that has what these bytes of a chunk use.
int version_of_colour(std::span<const uint8_t> bytes);

// Of a chunk's bytes, undecoded; none where no pixel is present.
std::optional<ColourCoding> coding_of_colour(std::span<const uint8_t> bytes, const Place& place, int version);

// Absent pixels get {0, 0, 0}.
RgbImage decode_colour_strip(std::span<const uint8_t> bytes, const Place& place, const DepthStrip& strip, int version);

}  // namespace ldp::file
