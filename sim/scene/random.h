// A small random generator whose numbers are the same on every machine (the standard library's distributions are not).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace ldp {

// Mixes 64 bits (finaliser of SplitMix64; Steele, Lea and Flood 2014).
constexpr uint64_t mix_bits(uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

class Random {
 public:
  explicit Random(uint64_t seed) : state_(mix_bits(seed)) {}

  uint64_t bits() { return mix_bits(state_++); }
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }  // [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  int below(int count) { return static_cast<int>(uniform() * count); }
  double normal() {  // mean 0, deviation 1 (Box and Muller)
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  uint64_t state_;
};

}  // namespace ldp
