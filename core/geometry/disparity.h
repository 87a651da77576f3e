// Depth as integers: disparity steps, and 4-bit codes against a range per block.
//
// Disparity is the position of an inverse depth inside the panorama's range, in kDisparitySteps equal steps:
//   w = w_far + (w_near - w_far) * disparity / kDisparitySteps.
// kDisparitySteps = 255 * 15, so that a code c in 0..15 against a block range (low, high) in 0..255 is the exact
// integer  disparity = 15 low + (high - low) c, and a label l of 16 over the whole range (0, 255) is 255 l.
// (As texture formats do: two end points and an index per pixel.)
#pragma once

#include <cstdint>

#include "core/base/plane.h"

namespace ldp {

constexpr int kLabels = 16;
constexpr int kDisparitySteps = 255 * 15;
constexpr uint16_t kNoDisparity = 0xFFFF;  // the pixel is absent from the layer

using DisparityMap = Plane<uint16_t>;  // 0 .. kDisparitySteps, or kNoDisparity

struct BlockRange {
  uint8_t low = 0, high = 255;  // low <= high
  friend bool operator==(const BlockRange&, const BlockRange&) = default;
};

// 4-bit depth of one layer. Blocks are block_px x block_px pixels from the top left corner, the last ones cut short;
// block_px = 0 means one range for the whole layer. Codes of absent pixels are 0.
struct DepthCodes {
  int block_px = 0;
  Plane<BlockRange> ranges;
  Plane<uint8_t> codes;  // 0 .. 15, one per pixel

  BlockRange range(int x, int y) const {
    return block_px == 0 ? ranges.samples[0] : ranges.at(x / block_px, y / block_px);
  }
  uint16_t disparity(int x, int y) const {
    const BlockRange range = this->range(x, y);
    return static_cast<uint16_t>(15 * range.low + (range.high - range.low) * codes.at(x, y));
  }
  friend bool operator==(const DepthCodes&, const DepthCodes&) = default;
};

// The codes of a disparity map; block_px = 0: against (0, 255), the uniform codes of the paper. Blocks without a
// present pixel have the range (0, 0).
//
// tolerance = 0: the nearest codes; ranges are the tightest that hold their block's present pixels.
// tolerance > 0: codes that take few bytes, for disparities known to so many steps only (finer steps are noise, and
// cost). Code steps are multiples of the tolerance on one grid for all blocks, so that a surface keeps its disparities
// from block to block, and among the codes allowed a pixel takes the one of most of its neighbours.
DepthCodes encode_depth(const DisparityMap& disparity, int block_px, int tolerance = 0);

// How far a code may be from its pixel's disparity in a range of codes `span` = high - low disparities apart.
constexpr int allowed_error(int span, int tolerance) {
  return span <= tolerance ? tolerance : (span + tolerance + 1) / 2;
}

// The disparity map of codes; pixels with coverage 0 become kNoDisparity.
DisparityMap decode_depth(const DepthCodes& depth, const Plane<uint8_t>& coverage);

}  // namespace ldp
