#include "core/base/exact_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace ldp {
namespace {

constexpr int kSamples = 20000;

// Undefined where the quarters of a turn were no whole number of 64 bits: told by UBSan.
TEST(ExactMath, AnglesWithoutADigitOfTheirTurnAreNoFault) {
  for (const double angle : {-8.94e305, 1e300, 1e19}) exact_sine_cosine(angle);
}

TEST(ExactMath, SineAndCosineAgreeWithTheLibrary) {
  for (int i = 0; i < kSamples; ++i) {
    const double angle = (i - kSamples / 2) * 0.01037;
    const auto [s, c] = exact_sine_cosine(angle);
    ASSERT_NEAR(s, std::sin(angle), 2e-15) << angle;
    ASSERT_NEAR(c, std::cos(angle), 2e-15) << angle;
  }
}

TEST(ExactMath, LogarithmAndExponentialAgreeWithTheLibrary) {
  for (int i = 0; i < kSamples; ++i) {
    const double x = (i - kSamples / 2) * 0.03;
    ASSERT_NEAR(exact_exp(x) / std::exp(x), 1, 4e-15) << x;
    ASSERT_NEAR(exact_log(std::exp(x)), x, 2e-15 * std::max(1.0, std::abs(x))) << x;
  }
}

TEST(ExactMath, RoundingKeepsTheWantedBitsOfItsScale) {
  EXPECT_EQ(rounded(0.3, 2), 0.25);
  EXPECT_EQ(rounded(-0.3, 2), -0.25);
  EXPECT_EQ(rounded(0.375, 2), 0.5);
  EXPECT_EQ(rounded(300.0, 2, 1000.0), 256.0);  // steps of 512 / 4
  EXPECT_EQ(rounded(0.0, 24), 0.0);
  for (int i = 1; i < kSamples; ++i) {
    const double x = i * 0.0137, y = rounded(x, 20, x);
    ASSERT_LE(std::abs(y - x), x * 0x1p-21);
    ASSERT_EQ(rounded(y, 20, x), y);
  }
}

TEST(ExactMath, GivesTheSameBitsOnEveryMachine) {
  std::uint64_t sum = 0;
  const auto add = [&sum](double x) { sum = std::rotl(sum, 7) * 0x9e3779b97f4a7c15 + std::bit_cast<std::uint64_t>(x); };
  for (int i = 1; i < kSamples; ++i) {
    const double x = i * 0.00613;
    const auto [s, c] = exact_sine_cosine(x);
    add(s), add(c), add(exact_log(x)), add(exact_exp(x)), add(rounded(x, 20));
    add(exact_dot({s, c, x}, {c, x, s}));
  }
  EXPECT_EQ(sum, 1243165672738834337u);
}

}  // namespace
}  // namespace ldp
