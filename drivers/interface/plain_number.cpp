#include "drivers/interface/plain_number.h"

#include <array>
#include <charconv>
#include <cmath>

namespace ldp {

std::string plain_number(double value) {
  constexpr double kLeast = 1e-6, kMost = 1e15;
  const double size = std::abs(value);
  const bool fixed = size == 0 || (size >= kLeast && size < kMost);
  std::array<char, 64> text{};  // 17 digits, and at most as many zeros, fit
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 fixed ? std::chars_format::fixed : std::chars_format::scientific);
  return {text.data(), end.ptr};
}

}  // namespace ldp
