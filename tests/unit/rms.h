#pragma once

#include <cmath>

#include "core/base/plane.h"

namespace ldp::test {

// Of what two images of one size differ by [levels], over pixels and channels.
inline double rms(const RgbImage& a, const RgbImage& b) {
  double sum = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    const Rgb p = a.samples[i];
    const Rgb q = b.samples[i];
    sum += std::pow(p.r - q.r, 2) + std::pow(p.g - q.g, 2) + std::pow(p.b - q.b, 2);
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(a.samples.size())));
}

}  // namespace ldp::test
