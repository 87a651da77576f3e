// Exposure gains: factors of R, G and B that bring one photograph to the exposure of all.
//
// Of all but bright colours a gain is a plain factor. What a photograph clipped has lost its colour: a gain below 1
// would turn white into grey, or into a tint where the channels' gains differ; one above 1 would clip what the
// photograph still shows. So a level v of the largest channel becomes f(v) with f(255) = 255, with one slope where the
// plain factor ends:
//   g < 1, v > S:    f(v) = v (g + (1 - g) t^2),                    t = (v - S) / (255 - S),         S = 224
//   g > 1, g v > S:  f(v) = S + (255 - S) k t / (1 + (k - 1) t),    t = (g v - S) / (255 g - S),     S = 208
//                                                                   k = (255 g - S) / (255 - S).
// The other channels get the factor f(v) / v of their own gains at the same v, so that all factors meet in 1 at 255.
#pragma once

#include <array>
#include <cstddef>

namespace ldp {

using Gain = std::array<float, 3>;

class ExposureGain {
 public:
  explicit ExposureGain(const Gain& gain);

  // Of a colour in 0 .. 255 * units; a channel other than the largest may come to lie above.
  std::array<int, 3> operator()(const std::array<int, 3>& colour, int units) const;

  // The colour that becomes this one.
  std::array<int, 3> undone(const std::array<int, 3>& colour, int units) const;

 private:
  // In 1/4096, at a level of the largest channel.
  int factor(size_t channel, int level, int units) const;

  std::array<std::array<int, 257>, 3> factor_q12_{};  // by level of the largest channel; one more to interpolate
};

}  // namespace ldp
