#include "core/photos/exposure/photo_exposure.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace ldp {

PhotoExposure::PhotoExposure(DisplayExposure over_photo, int width, int height)
    : gain_({1, 1, 1}), over_photo_(std::move(over_photo)), width_(width), height_(height) {}

std::array<int, 3> PhotoExposure::operator()(const std::array<int, 3>& colour, int units, int x, int y) const {
  if (over_photo_.empty()) return gain_(colour, units);
  const auto factor = over_photo_.factors.at((x + 0.5) / width_, (y + 0.5) / height_);
  return with_light(colour, units, factor, over_photo_.response);
}

void PhotoExposure::apply(RgbImage& photo) const {
  constexpr int kUnits = 16;
  const auto stored = [](int v) { return static_cast<uint8_t>(std::clamp((v + kUnits / 2) / kUnits, 0, 255)); };
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      Rgb& c = photo.at(x, y);
      const auto e = (*this)({c.r * kUnits, c.g * kUnits, c.b * kUnits}, kUnits, x, y);
      c = {stored(e[0]), stored(e[1]), stored(e[2])};
    }
}

}  // namespace ldp
