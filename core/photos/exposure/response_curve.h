// A camera's response: which light gives which level of its photographs, the same for R, G and B.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ldp {

// Light at levels 0, 16, .. 256, linear between them; rising, none at 0. Its unit is of no meaning.
struct ResponseCurve {
  static constexpr size_t kKnots = 17;
  static constexpr int kLevelsPerKnot = 16;

  std::array<uint32_t, kKnots> light{};  // all 0: not known

  bool empty() const { return light.back() == 0; }
  double light_of(double level) const;  // of a level 0 .. 256; not of an empty one
  double level_of(double light) const;  // the other way round, at most 256

  friend bool operator==(const ResponseCurve&, const ResponseCurve&) = default;
};

// A colour in 0 .. 255 * units as the camera would have shown it with so much more light, a factor a channel.
// What is white stays white: a photograph does not tell how much brighter it was, so factors below 1 lose their effect
// as the largest channel goes from level 224 to 255. The same on every machine.
std::array<int, 3> with_light(const std::array<int, 3>& colour, int units, const std::array<double, 3>& factor,
                              const ResponseCurve& response);

}  // namespace ldp
