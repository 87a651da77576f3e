#include "core/photos/exposure/response_curve.h"

#include <algorithm>
#include <cmath>

#include "core/photos/exposure_tuning.h"

namespace ldp {

double ResponseCurve::light_of(double level) const {
  const double at = level / kLevelsPerKnot;
  const size_t knot = std::min(static_cast<size_t>(at), kKnots - 2);
  return light[knot] + (at - static_cast<double>(knot)) * (light[knot + 1] - light[knot]);
}

double ResponseCurve::level_of(double of) const {
  if (of >= light.back()) return kLevelsPerKnot * static_cast<double>(kKnots - 1);
  size_t knot = 0;
  while (of >= light[knot + 1]) ++knot;
  return kLevelsPerKnot * (static_cast<double>(knot) + (of - light[knot]) / (light[knot + 1] - light[knot]));
}

std::array<int, 3> with_light(const std::array<int, 3>& colour, int units, const std::array<double, 3>& factor,
                              const ResponseCurve& response) {
  using exposure::kDarkShoulder, exposure::kWhite;
  const double largest = std::max({colour[0], colour[1], colour[2]}) / static_cast<double>(units);
  const double t = std::max(0.0, (largest - kDarkShoulder) / (kWhite - kDarkShoulder));
  std::array<int, 3> result{};
  for (size_t c = 0; c < 3; ++c) {
    const double level = std::clamp(colour[c] / static_cast<double>(units), 0.0, kWhite);
    double to = std::min(kWhite, response.level_of(factor[c] * response.light_of(level)));
    if (factor[c] < 1) to += std::min(1.0, t * t) * (level - to);
    result[c] = static_cast<int>(std::floor(to * units + 0.5));
  }
  return result;
}

}  // namespace ldp
