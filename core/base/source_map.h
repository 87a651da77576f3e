// The photograph that each pixel of a layer is taken from: a byte a pixel, two where there are more than 255.
#pragma once

#include <cstdint>
#include <utility>

#include "core/base/plane.h"

namespace ldp {

constexpr int kMostSources = 16383;  // photographs: what is kept of seams numbers them in 14 bits
constexpr int kNoSource = 65535;

class SourceMap {
 public:
  static constexpr int kMostNarrow = 255;  // photographs

  SourceMap() = default;
  // All kNoSource.
  SourceMap(int width, int height, int photographs) {
    if (photographs > kMostNarrow)
      wide_ = Plane<uint16_t>(width, height, static_cast<uint16_t>(kNoSource));
    else
      narrow_ = Plane<uint8_t>(width, height, kNarrowNone);
  }
  // Of at most 255 photographs, 255 meaning none.
  explicit SourceMap(Plane<uint8_t> narrow) : narrow_(std::move(narrow)) {}

  int width() const { return wide_.empty() ? narrow_.width : wide_.width; }
  int height() const { return wide_.empty() ? narrow_.height : wide_.height; }
  int at(int x, int y) const {
    if (!wide_.empty()) return wide_.at(x, y);
    const uint8_t source = narrow_.at(x, y);
    return source == kNarrowNone ? kNoSource : source;
  }
  void set(int x, int y, int source) {
    if (wide_.empty())
      narrow_.at(x, y) = source == kNoSource ? kNarrowNone : static_cast<uint8_t>(source);
    else
      wide_.at(x, y) = static_cast<uint16_t>(source);
  }

  // From column x and row y on.
  SourceMap part(int x, int y, int width, int height) const {
    SourceMap result(width, height, wide_.empty() ? kMostNarrow : kMostSources);
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i) result.set(i, j, at(x + i, y + j));
    return result;
  }

 private:
  static constexpr uint8_t kNarrowNone = 255;
  Plane<uint8_t> narrow_;
  Plane<uint16_t> wide_;
};

}  // namespace ldp
