#include "core/solve/moves/smoothness.h"

#include <cmath>
#include <stdexcept>

namespace ldp::solve {

namespace {

int product(int coarse, int fine) { return (coarse * fine + 64) / 128; }

// The entry whose product with fine[0] comes nearest to the value wanted.
uint8_t coarse_entry(double wanted, int fine) {
  int best = 0;
  for (int entry = 1; entry < 256; ++entry)
    if (std::abs(product(entry, fine) - wanted) < std::abs(product(best, fine) - wanted)) best = entry;
  return static_cast<uint8_t>(best);
}

}  // namespace

Smoothness::Smoothness(int step, double contrast, int truncation, int largest_factor)
    : truncation_(truncation),
      coarse_(static_cast<size_t>(largest_factor + 1) * 16),
      weight_(static_cast<size_t>(largest_factor + 1) * 256) {
  if (step < 1 || truncation < 1 || largest_factor < 1 || step * truncation * largest_factor > kWidestPair)
    throw std::logic_error("Smoothness: step * truncation * factor must lie in 1 .. 250");
  for (size_t i = 0; i < 16; ++i)
    fine_[i] = static_cast<uint8_t>(std::lround(127 * std::exp(-contrast * static_cast<double>(i))));
  for (size_t factor = 1; factor <= static_cast<size_t>(largest_factor); ++factor) {
    const double full = static_cast<double>(factor) * step;
    for (size_t i = 0; i < 16; ++i)
      coarse_[factor * 16 + i] = coarse_entry(full * std::exp(-16.0 * contrast * static_cast<double>(i)), fine_[0]);
    for (size_t d = 0; d < 256; ++d)
      weight_[factor * 256 + d] = static_cast<uint8_t>(product(coarse_[factor * 16 + d / 16], fine_[d % 16]));
  }
}

}  // namespace ldp::solve
