// Coverage, block ranges and depth codes of one strip of one layer (FORMAT.md, "Depth"): predictive context coding with
// an adaptive binary range coder.
//
// Takes and gives a strip: all rows of some columns, standing alone, so that strips decode one without the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/disparity.h"
#include "core/panorama/file/bytes.h"

namespace ldp::file {

constexpr int kTile = 16;  // pixels; coverage and colour are kept per tile

enum class TileState : uint8_t { empty = 0, full = 1, mixed = 2 };

struct DepthStrip {
  int block_px = 0;          // 0: one range for all
  Plane<BlockRange> ranges;  // 1x1 when block_px is 0; else of the blocks of this strip
  Plane<TileState> tiles;
  Plane<uint8_t> coverage;  // 0 or 1
  Plane<uint8_t> codes;     // 0 .. 15
};

Plane<TileState> tile_states(const Plane<uint8_t>& coverage);

std::vector<uint8_t> encode_depth_strip(const DepthStrip& strip);

// `strip` comes with its sizes, block_px and, when block_px is 0, its range; the rest is filled in, up to where a
// stream that ends too early does.
void decode_depth_strip(std::span<const uint8_t> bytes, const Place& place, DepthStrip& strip);

}  // namespace ldp::file
