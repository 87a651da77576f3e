#include "core/view/image_quality.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace ldp {
namespace {

uint8_t wrapped(int value) { return static_cast<uint8_t>(value % 256); }

RgbImage pattern(int shift_r, int shift_g, int shift_b) {
  RgbImage image(31, 23);
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 31; ++x)
      image.at(x, y) = {wrapped(7 * x + 13 * y + shift_r), wrapped(x * x + 3 * y + shift_g * x),
                        wrapped(5 * x * y + shift_b)};
  }
  return image;
}

// Known answers were computed by an independent program in NumPy.
TEST(ViewQuality, MatchesKnownAnswers) {
  Plane<uint8_t> alpha(31, 23, 255);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 6; ++x) alpha.at(x, y) = 0;
  }
  const ViewQuality quality = view_quality(pattern(0, 0, 11), alpha, pattern(9, 1, 31));
  EXPECT_NEAR(quality.psnr_db, 12.885313663465059, 1e-9);
  EXPECT_NEAR(quality.ssim, 0.5615851392659889, 1e-9);
  EXPECT_NEAR(quality.psnr_covered_db, 13.225993161876119, 1e-9);
  EXPECT_NEAR(quality.holes, 0.0757363253856943, 1e-12);
}

TEST(ViewQuality, IsPerfectForTheSamePicture) {
  const ViewQuality quality = view_quality(pattern(0, 0, 0), {}, pattern(0, 0, 0));
  EXPECT_GT(quality.psnr_db, 100);
  EXPECT_NEAR(quality.ssim, 1, 1e-12);
  EXPECT_EQ(quality.holes, 0);
}

TEST(ViewQuality, LeavesExposureAsideWhenMatched) {
  RgbImage dark(20, 20), light(20, 20);
  for (int i = 0; i < 400; ++i) {
    const auto at = static_cast<size_t>(i);
    dark.samples[at] = {static_cast<uint8_t>(i % 100), static_cast<uint8_t>(i % 90), 50};
    light.samples[at] = {static_cast<uint8_t>(2 * (i % 100)), static_cast<uint8_t>(i % 90), 100};
  }
  const ViewQuality quality = view_quality(dark, {}, light);
  EXPECT_LT(quality.psnr_db, 20);
  EXPECT_GT(quality.psnr_matched_db, 60);
}

TEST(ViewQuality, RefusesPicturesOfUnlikeSizes) {
  EXPECT_THROW(view_quality(RgbImage(3, 3), {}, RgbImage(3, 4)), std::logic_error);
}

}  // namespace
}  // namespace ldp
