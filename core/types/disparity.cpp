#include "disparity.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace ldp {
namespace {

struct Block {
  int x0, y0, x1, y1;
};

BlockRange range_of(const DisparityMap& disparity, const Block& block, int least_span) {
  int lowest = kDisparitySteps, highest = 0;
  for (int y = block.y0; y < block.y1; ++y)
    for (int x = block.x0; x < block.x1; ++x) {
      const int d = disparity.at(x, y);
      if (d == kNoDisparity) continue;
      lowest = std::min(lowest, d);
      highest = std::max(highest, d);
    }
  if (lowest > highest) return {0, 0};
  const int span = std::max((highest + 14) / 15 - lowest / 15, least_span);
  const int low = std::min(lowest / 15, 255 - span);
  return {static_cast<uint8_t>(low), static_cast<uint8_t>(low + span)};
}

void encode_block(const DisparityMap& disparity, const Block& block, BlockRange range, Plane<uint8_t>& codes) {
  const int span = range.high - range.low;
  for (int y = block.y0; y < block.y1; ++y)
    for (int x = block.x0; x < block.x1; ++x) {
      const int d = disparity.at(x, y);
      if (d == kNoDisparity || span == 0) continue;
      codes.at(x, y) = static_cast<uint8_t>(std::clamp((d - 15 * range.low + span / 2) / span, 0, 15));
    }
}

}  // namespace

DepthCodes encode_depth(const DisparityMap& disparity, int block_px, int least_span) {
  if (block_px < 0) throw std::logic_error("encode_depth: block_px is " + std::to_string(block_px) + ", must be >= 0");
  if (least_span < 0 || least_span > 255)
    throw std::logic_error("encode_depth: least_span is " + std::to_string(least_span) + ", must be 0 to 255");
  DepthCodes depth;
  depth.block_px = block_px;
  depth.codes = Plane<uint8_t>(disparity.width, disparity.height);
  const int step_x = block_px == 0 ? std::max(1, disparity.width) : block_px;
  const int step_y = block_px == 0 ? std::max(1, disparity.height) : block_px;
  depth.ranges = block_px == 0 ? Plane<BlockRange>(1, 1)
                               : Plane<BlockRange>((disparity.width + step_x - 1) / step_x,
                                                   (disparity.height + step_y - 1) / step_y);
  for (int by = 0; by < depth.ranges.height; ++by)
    for (int bx = 0; bx < depth.ranges.width; ++bx) {
      const Block block{bx * step_x, by * step_y, std::min((bx + 1) * step_x, disparity.width),
                        std::min((by + 1) * step_y, disparity.height)};
      if (block_px != 0) depth.ranges.at(bx, by) = range_of(disparity, block, least_span);
      encode_block(disparity, block, depth.ranges.at(bx, by), depth.codes);
    }
  return depth;
}

DisparityMap decode_depth(const DepthCodes& depth, const Plane<uint8_t>& coverage) {
  DisparityMap disparity(depth.codes.width, depth.codes.height, kNoDisparity);
  for (int y = 0; y < disparity.height; ++y)
    for (int x = 0; x < disparity.width; ++x)
      if (coverage.at(x, y)) disparity.at(x, y) = depth.disparity(x, y);
  return disparity;
}

}  // namespace ldp
