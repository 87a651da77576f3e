// The smoothness term in integers: V = min(|position difference|, truncation) * weight(|grey difference|), where
// weight(d) is about step * exp(-contrast d).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

namespace ldp {

// An exponential factorises, so the 256-entry table is the product of two tables of 16 entries, which vector
// instructions look up without memory: weight(d) = (coarse[d / 16] * fine[d % 16] + 128) / 256.
class Smoothness {
 public:
  // step: weight at equal greys, 1 .. 255, with step * truncation <= 255.
  Smoothness(int step, double contrast, int truncation);

  int weight(int grey_difference) const { return weight_[static_cast<size_t>(grey_difference)]; }
  int operator()(int position_difference, int grey_difference) const {
    return std::min(std::abs(position_difference), truncation_) * weight(std::abs(grey_difference));
  }
  int step() const { return weight_[0]; }
  int truncation() const { return truncation_; }
  const std::array<uint8_t, 16>& coarse() const { return coarse_; }
  const std::array<uint8_t, 16>& fine() const { return fine_; }

 private:
  int truncation_;
  std::array<uint8_t, 16> coarse_{}, fine_{};
  std::array<uint8_t, 256> weight_{};
};

}  // namespace ldp
