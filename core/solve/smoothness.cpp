#include "smoothness.h"

#include <cmath>
#include <stdexcept>

namespace ldp {

Smoothness::Smoothness(int step, double contrast, int truncation) : truncation_(truncation) {
  if (step < 1 || truncation < 1 || step * truncation > 255)
    throw std::logic_error("Smoothness: step * truncation must lie in 1 .. 255");
  for (size_t i = 0; i < 16; ++i) {
    coarse_[i] = static_cast<uint8_t>(std::lround(step * std::exp(-16.0 * contrast * static_cast<double>(i))));
    fine_[i] = static_cast<uint8_t>(std::lround(255 * std::exp(-contrast * static_cast<double>(i))));
  }
  for (size_t d = 0; d < 256; ++d) weight_[d] = static_cast<uint8_t>((coarse_[d / 16] * fine_[d % 16] + 128) / 256);
}

}  // namespace ldp
