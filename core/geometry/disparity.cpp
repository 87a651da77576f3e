#include "core/geometry/disparity.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <string>

namespace ldp {
namespace {

// The smallest and largest disparity of a block's present pixels.
struct Extent {
  int lowest = kDisparitySteps, highest = -1;
};

Extent extent_of(const DisparityMap& disparity, int x0, int y0, int block_px) {
  Extent extent;
  for (int y = y0; y < std::min(disparity.height, y0 + block_px); ++y)
    for (int x = x0; x < std::min(disparity.width, x0 + block_px); ++x) {
      const int d = disparity.at(x, y);
      if (d == kNoDisparity) continue;
      extent.lowest = std::min(extent.lowest, d);
      extent.highest = std::max(extent.highest, d);
    }
  return extent;
}

BlockRange range_from(int low, int span) { return {static_cast<uint8_t>(low), static_cast<uint8_t>(low + span)}; }

BlockRange tightest_range(const Extent& extent) {
  return range_from(extent.lowest / 15, (extent.highest + 14) / 15 - extent.lowest / 15);
}

int floor_div(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

// The low end of a range that holds a block and whose codes are multiples of `span`; -1 where there is none.
int low_on_grid(const Extent& extent, int span, int tolerance) {
  const int error = allowed_error(span, tolerance);
  const int first = (extent.lowest + error) / span;  // multiple that suffices for the lowest, and for the highest
  const int last = (std::max(0, extent.highest - error) + span - 1) / span;
  // 15 low is a multiple of the span when low is one of `unit`; each moves the codes by `shift`.
  const int divisor = std::gcd(15, span), unit = span / divisor, shift = 15 / divisor;
  const int least = std::max(0, floor_div(last - 15 + shift - 1, shift));
  const int most = std::min(first / shift, (255 - span) / unit);
  const int middle = floor_div(first + last - 15 + shift, 2 * shift);
  return least > most ? -1 : unit * std::clamp(middle, least, most);
}

BlockRange range_within(const Extent& extent, int tolerance) {
  const int single = std::min(255, ((extent.lowest + extent.highest) / 2 + 7) / 15);
  if (std::max(15 * single - extent.lowest, extent.highest - 15 * single) <= tolerance) return range_from(single, 0);
  const int step = (tolerance + 2) / 3 * 3;  // so that ranges on the grid are never farther apart than 5 codes
  for (int span = step; span < 255; span += step)
    if (const int low = low_on_grid(extent, span, tolerance); low >= 0) return range_from(low, span);
  return {0, 255};
}

void choose_ranges(const DisparityMap& disparity, int tolerance, DepthCodes& depth) {
  for (int by = 0; by < depth.ranges.height; ++by)
    for (int bx = 0; bx < depth.ranges.width; ++bx) {
      const Extent extent = extent_of(disparity, bx * depth.block_px, by * depth.block_px, depth.block_px);
      depth.ranges.at(bx, by) = extent.highest < 0 ? BlockRange{0, 0}
                                : tolerance == 0   ? tightest_range(extent)
                                                   : range_within(extent, tolerance);
    }
}

// Codes of disparities in one range, by a multiplication instead of a division: exact, as products of a disparity and a
// span stay below 2^kShift.
class Coder {
 public:
  explicit Coder(BlockRange range)
      : span_(range.high - range.low), base_(15 * range.low), inverse_(span_ == 0 ? 0 : (1U << kShift) / width() + 1) {}

  int span() const { return span_; }
  int disparity(int code) const { return base_ + span_ * code; }

  // The code nearest to a disparity, and whether the range holds it.
  uint8_t nearest(int disparity) const { return code(std::clamp(above(disparity), 0, kLabels * span_ - 1)); }
  bool holds(int disparity) const { return static_cast<unsigned>(above(disparity)) < kLabels * width(); }
  uint8_t held(int disparity) const { return code(above(disparity)); }

 private:
  static constexpr int kShift = 22;
  unsigned width() const { return static_cast<unsigned>(span_); }
  int above(int disparity) const { return disparity - base_ + span_ / 2; }
  uint8_t code(int above) const { return static_cast<uint8_t>((static_cast<unsigned>(above) * inverse_) >> kShift); }

  int span_, base_;
  unsigned inverse_;
};

// Calls use(range, x0, x1, y) for every row of every block.
template <typename Use>
void for_block_rows(const DepthCodes& depth, Use use) {
  const int width = depth.codes.width, side = depth.block_px == 0 ? std::max(width, 1) : depth.block_px;
  for (int y = 0; y < depth.codes.height; ++y)
    for (int x = 0; x < width; x += side) use(depth.range(x, y), x, std::min(x + side, width), y);
}

void take_nearest(const DisparityMap& disparity, DepthCodes& depth) {
  for_block_rows(depth, [&](BlockRange range, int x0, int x1, int y) {
    const Coder coder(range);
    if (coder.span() == 0) return;
    const uint16_t* from = disparity.row(y);
    uint8_t* to = depth.codes.row(y);
    for (int x = x0; x < x1; ++x) to[x] = from[x] == kNoDisparity ? uint8_t{0} : coder.nearest(from[x]);
  });
}

// Moves codes to those of most of their neighbours.
class Voting {
 public:
  Voting(const DisparityMap& disparity, int tolerance, DepthCodes& depth)
      : wanted_(disparity),
        tolerance_(tolerance),
        depth_(depth),
        now_(disparity.width + 2, disparity.height + 2, kNoDisparity) {
    for_block_rows(depth, [&](BlockRange range, int x0, int x1, int y) {
      const Coder coder(range);
      const uint16_t* wanted = disparity.row(y);
      const uint8_t* codes = depth.codes.row(y);
      uint16_t* now = now_.row(y + 1) + 1;
      for (int x = x0; x < x1; ++x)
        if (wanted[x] != kNoDisparity) now[x] = static_cast<uint16_t>(coder.disparity(codes[x]));
    });
  }

  void run() {
    for (int y = 0; y < wanted_.height; ++y)
      for (int x = 0; x < wanted_.width; ++x) vote(x, y);
    for (int y = wanted_.height; y-- > 0;)
      for (int x = wanted_.width; x-- > 0;) vote(x, y);
  }

 private:
  void vote(int x, int y) {
    uint16_t* own = now_.row(y + 1) + x + 1;
    if (*own == kNoDisparity) return;
    const int row = now_.width;
    const std::array<uint16_t, 8> beside = {own[-1],       own[1],        own[-row],    own[row],
                                            own[-row - 1], own[-row + 1], own[row - 1], own[row + 1]};
    if (std::all_of(beside.begin(), beside.end(), [&](uint16_t d) { return d == *own; })) return;
    const Coder coder(depth_.range(x, y));
    if (coder.span() == 0) return;
    std::array<int, kLabels> votes{};
    for (size_t k = 0; k < beside.size(); ++k)
      if (coder.holds(beside[k])) votes[coder.held(beside[k])] += k < 4 ? 3 : 2;
    uint8_t& code = depth_.codes.at(x, y);
    for (int c = 0; c < kLabels; ++c) {
      if (votes[static_cast<size_t>(c)] <= votes[code]) continue;
      const int error = std::abs(coder.disparity(c) - wanted_.at(x, y));
      if (error <= allowed_error(coder.span(), tolerance_)) code = static_cast<uint8_t>(c);
    }
    *own = static_cast<uint16_t>(coder.disparity(code));
  }

  const DisparityMap& wanted_;
  int tolerance_;
  DepthCodes& depth_;
  DisparityMap now_;  // what the codes mean, with a border of absent pixels
};

}  // namespace

DepthCodes encode_depth(const DisparityMap& disparity, int block_px, int tolerance) {
  if (block_px < 0) throw std::logic_error("encode_depth: block_px is " + std::to_string(block_px) + ", must be >= 0");
  if (tolerance < 0 || tolerance > 255)
    throw std::logic_error("encode_depth: tolerance is " + std::to_string(tolerance) + ", must be 0 to 255");
  const auto blocks = [&](int pixels) { return (pixels + block_px - 1) / block_px; };
  DepthCodes depth{
      block_px,
      block_px == 0 ? Plane<BlockRange>(1, 1) : Plane<BlockRange>(blocks(disparity.width), blocks(disparity.height)),
      Plane<uint8_t>(disparity.width, disparity.height)};
  if (block_px != 0) choose_ranges(disparity, tolerance, depth);
  take_nearest(disparity, depth);
  if (tolerance > 0) Voting(disparity, tolerance, depth).run();
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
