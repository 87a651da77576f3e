#include "core/base/exact_math.h"

#include <cmath>

namespace ldp {
namespace {

constexpr double kLn2High = 0x1.62e42fee00000p-1;  // 21 trailing zero bits: k * kLn2High is exact
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
constexpr double kHalfPiHigh = 0x1.921fb54400000p+0;
constexpr double kHalfPiLow = 0x1.0b4611a626331p-34;

// Taylor series for |x| <= pi / 4.
double sine_series(double x) {
  const double x2 = x * x;
  double sum = 1;
  for (int k = 19; k >= 3; k -= 2) sum = 1 - sum * x2 / (k * (k - 1));
  return x * sum;
}

double cosine_series(double x) {
  const double x2 = x * x;
  double sum = 1;
  for (int k = 20; k >= 2; k -= 2) sum = 1 - sum * x2 / (k * (k - 1));
  return sum;
}

}  // namespace

SineCosine exact_sine_cosine(double angle_rad) {
  const double quarter = std::floor(angle_rad / (kHalfPiHigh + kHalfPiLow) + 0.5);
  const double rest = (angle_rad - quarter * kHalfPiHigh) - quarter * kHalfPiLow;
  const double s = sine_series(rest), c = cosine_series(rest);
  // Beyond 2^62 quarters, which only a damaged file asks for, no digit of the angle tells which one it is.
  switch (std::abs(quarter) < 0x1p62 ? static_cast<long long>(quarter) & 3 : 0) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double exact_log(double x) {
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);
  if (mantissa < 0.70710678118654752) {
    mantissa *= 2;
    --exponent;
  }
  const double t = (mantissa - 1) / (mantissa + 1), t2 = t * t;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = sum * t2 + 1.0 / k;
  return exponent * kLn2High + (exponent * kLn2Low + 2 * t * sum);
}

double exact_exp(double x) {
  const double power = std::floor(x / (kLn2High + kLn2Low) + 0.5);
  const double rest = (x - power * kLn2High) - power * kLn2Low;
  double sum = 1;
  for (int k = 16; k >= 1; --k) sum = 1 + sum * rest / k;
  return std::ldexp(sum, static_cast<int>(power));
}

double rounded(double x, int bits, double scale) {
  int exponent = 0;
  std::frexp(scale, &exponent);
  const double step = std::ldexp(1.0, exponent - 1 - bits);
  return std::floor(x / step + 0.5) * step;
}

}  // namespace ldp
