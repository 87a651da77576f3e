// The smoothness term in integers: V = min(|position difference|, truncation) * weight(|grey difference|), where
// weight(d) is about factor * step * exp(-contrast d).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace ldp::solve {

constexpr int kWidestPair = 250;  // V never exceeds this, so that messages fit 8 bits

// An exponential factorises, so the 256-entry table is the product of two tables of 16 entries, which vector
// instructions look up without memory: weight(d) = (coarse[d / 16] * fine[d % 16] + 64) / 128.
class Smoothness {
 public:
  // step: weight at equal greys and factor 1; step * truncation * largest_factor <= kWidestPair. Factors multiply the
  // weight of single edges, 0 .. largest_factor.
  Smoothness(int step, double contrast, int truncation, int largest_factor = 1);

  int weight(int factor, int grey_difference) const {
    return weight_[static_cast<size_t>(factor * 256 + std::abs(grey_difference))];
  }
  int operator()(int factor, int position_difference, int grey_difference) const {
    return std::min(std::abs(position_difference), truncation_) * weight(factor, grey_difference);
  }
  int truncation() const { return truncation_; }
  const uint8_t* coarse() const { return coarse_.data(); }  // 16 entries per factor
  const uint8_t* fine() const { return fine_.data(); }
  const uint8_t* weights() const { return weight_.data(); }  // 256 entries per factor

 private:
  int truncation_;
  std::array<uint8_t, 16> fine_{};
  std::vector<uint8_t> coarse_, weight_;
};

}  // namespace ldp::solve
