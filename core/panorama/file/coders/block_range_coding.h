// Lowest and highest disparity of each block of a strip, predicted from its neighbours.
//
// Runs in the encoder and in the decoder (depth_coding.cpp), which differ in Coder only.
#pragma once

#include <algorithm>
#include <array>

#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/coders/range_coder.h"

namespace ldp::file {

struct RangeModels {
  struct Number {
    std::array<BitModel, 9> longer;                // one more digit?
    std::array<std::array<BitModel, 2>, 9> digit;  // by number of digits; the highest on its own
  };
  Number low;
  std::array<Number, 3> span;
};

// A whole number -255 .. 255 by an Exp-Golomb code of 2 |v| - (v > 0). Gives something beyond when the stream is
// damaged.
template <typename Coder>
int code_number(Coder& coder, RangeModels::Number& models, int value) {
  const int folded = (value > 0 ? 2 * value - 1 : -2 * value) + 1;
  size_t digits = 0;
  while (digits < 8 && coder.bit(models.longer[digits], folded >> (digits + 1) != 0)) ++digits;
  int result = 1;
  for (size_t i = digits; i-- > 0;)
    result = result << 1 | static_cast<int>(coder.bit(models.digit[digits][i + 1 == digits], (folded >> i & 1) != 0));
  --result;
  return result & 1 ? (result + 1) / 2 : -(result / 2);
}

// Planar prediction within the bounds of the left and upper neighbours; absent ones are -1.
inline int predict(const Plane<int16_t>& values, int x, int y) {
  const auto at = [&](int px, int py) { return values.contains(px, py) ? int{values.at(px, py)} : -1; };
  const int west = at(x - 1, y);
  const int north = at(x, y - 1);
  const int north_west = at(x - 1, y - 1);
  if (west < 0 && north < 0) return 0;
  if (west < 0) return north;
  if (north < 0) return west;
  if (north_west < 0) return (west + north) / 2;
  return std::clamp(west + north - north_west, std::min(west, north), std::max(west, north));
}

inline bool any_present(const DepthStrip& strip, int bx, int by) {
  const int x1 = std::min(strip.coverage.width, (bx + 1) * strip.block_px);
  const int y1 = std::min(strip.coverage.height, (by + 1) * strip.block_px);
  for (int y = by * strip.block_px; y < y1; ++y) {
    const uint8_t* row = strip.coverage.row(y);
    if (std::find(row + ptrdiff_t{bx} * strip.block_px, row + x1, 1) != row + x1) return true;
  }
  return false;
}

template <typename Coder>
bool code_ranges(Coder& coder, DepthStrip& strip) {
  RangeModels models;
  Plane<int16_t> lows(strip.ranges.width, strip.ranges.height, -1);
  Plane<int16_t> spans = lows;
  for (int y = 0; y < strip.ranges.height && !coder.ended(); ++y)
    for (int x = 0; x < strip.ranges.width; ++x) {
      if (!any_present(strip, x, y)) continue;
      BlockRange& range = strip.ranges.at(x, y);
      const int expected_low = predict(lows, x, y);
      const int expected_span = predict(spans, x, y);
      const size_t context = static_cast<size_t>((expected_span > 2) + (expected_span > 10));
      const int low = expected_low + code_number(coder, models.low, range.low - expected_low);
      const int span = expected_span + code_number(coder, models.span[context], range.high - range.low - expected_span);
      if (low < 0 || span < 0 || low + span > 255) return false;
      range = {static_cast<uint8_t>(low), static_cast<uint8_t>(low + span)};
      lows.at(x, y) = static_cast<int16_t>(low);
      spans.at(x, y) = static_cast<int16_t>(span);
    }
  return true;
}

}  // namespace ldp::file
