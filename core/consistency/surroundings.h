// A pixel and the colours that occur within a pixel of it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/plane.h"

namespace ldp::consistency {

class Surroundings {
 public:
  Surroundings() = default;
  Surroundings(const RgbImage& image, int x, int y) {
    const Rgb own = image.at(x, y);
    colour_ = {own.r, own.g, own.b};
    const bool inside = x > 0 && y > 0 && x + 1 < image.width && y + 1 < image.height;
    inside ? take_square(image, x, y) : take_what_there_is(image, x, y);
  }

  const std::array<int, 3>& colour() const { return colour_; }

  // Whether each channel lies within the range that occurs here, or so many levels beside it.
  bool hold(const std::array<int, 3>& c, int tolerance) const {
    for (size_t k = 0; k < 3; ++k)
      if (c[k] < low_[k] - tolerance || c[k] > high_[k] + tolerance) return false;
    return true;
  }

 private:
  // Rows first: their bytes lie side by side.
  void take_square(const RgbImage& image, int x, int y) {
    static_assert(sizeof(Rgb) == 3);
    const auto row = [&](int ny) { return reinterpret_cast<const uint8_t*>(image.row(ny) + x - 1); };
    const uint8_t *above = row(y - 1), *on = row(y), *below = row(y + 1);
    std::array<uint8_t, 9> least, most;
    for (size_t i = 0; i < 9; ++i) {
      least[i] = std::min(std::min(above[i], on[i]), below[i]);
      most[i] = std::max(std::max(above[i], on[i]), below[i]);
    }
    for (size_t k = 0; k < 3; ++k) {
      low_[k] = std::min(std::min(least[k], least[k + 3]), least[k + 6]);
      high_[k] = std::max(std::max(most[k], most[k + 3]), most[k + 6]);
    }
  }
  void take_what_there_is(const RgbImage& image, int x, int y) {
    for (int ny = std::max(0, y - 1); ny <= std::min(image.height - 1, y + 1); ++ny)
      for (int nx = std::max(0, x - 1); nx <= std::min(image.width - 1, x + 1); ++nx) {
        const Rgb c = image.at(nx, ny);
        const std::array<uint8_t, 3> channels{c.r, c.g, c.b};
        for (size_t k = 0; k < 3; ++k)
          low_[k] = std::min(low_[k], channels[k]), high_[k] = std::max(high_[k], channels[k]);
      }
  }

  std::array<int, 3> colour_{};
  std::array<uint8_t, 3> low_{255, 255, 255}, high_{0, 0, 0};
};

}  // namespace ldp::consistency
