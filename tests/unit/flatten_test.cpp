#include "core/rectify/background_subtraction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/rectify/resample.h"

namespace ldp::rectification {
namespace {

constexpr int kWidth = 320, kHeight = 200;

Plane<uint16_t> picture(const std::function<double(int, int)>& grey) {
  Plane<uint16_t> plane(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) plane.at(x, y) = static_cast<uint16_t>(std::lround(grey(x, y) * kSampleScale));
  return plane;
}

double grey(const Plane<uint16_t>& plane, int x, int y) { return plane.at(x, y) / static_cast<double>(kSampleScale); }

TEST(Flatten, ASurfaceOfOneGreyKeepsAFifthOfItsDistanceFromTheMiddle) {
  for (const int level : {0, 9, 128, 200, 255}) {
    const auto flat = flatten(picture([&](int, int) { return level; }), {});
    for (const int x : {0, 1, 100, kWidth - 1})
      for (const int y : {0, 77, kHeight - 1}) EXPECT_NEAR(grey(flat, x, y), 128 + 0.2 * (level - 128), 0.1) << level;
  }
}

TEST(Flatten, SlowShadingGoesAndTextureStays) {
  const auto texture = [](int x, int y) { return 4 * std::sin(x * 1.3) * std::cos(y * 0.9); };
  const auto flat = flatten(picture([&](int x, int y) { return 60 + 0.4 * x + texture(x, y); }), {});
  const auto plain = flatten(picture([&](int x, int) { return 60 + 0.4 * x; }), {});
  EXPECT_LT(std::abs(grey(plain, 300, 100) - grey(plain, 20, 100)), 0.25 * 0.4 * 280);
  double kept = 0, all = 0;
  for (int x = 20; x < 300; ++x)
    for (int y = 20; y < 180; ++y) {
      kept += (grey(flat, x, y) - grey(plain, x, y)) * texture(x, y);
      all += texture(x, y) * texture(x, y);
    }
  EXPECT_GT(kept / all, 0.75);
  EXPECT_LT(kept / all, 1.05);
}

TEST(Flatten, WhatStandsBesideASurfaceDoesNotMatter) {
  const auto beside = [](double other) {
    return flatten(picture([=](int x, int) { return x < 160 ? 90.0 : other; }), {});
  };
  const auto dark = beside(20), bright = beside(230);
  for (int x = 0; x < 160; ++x) EXPECT_EQ(dark.at(x, 100), bright.at(x, 100)) << x;
}

TEST(Flatten, OfAMirroredPictureIsTheMirroredOne) {
  const auto scene = [](int x, int y) { return 128 + 100 * std::sin(x * 0.05 + 0.3) * std::cos(y * 0.04 + x * 0.01); };
  const auto flat = flatten(picture(scene), {});
  const auto sideways = flatten(picture([&](int x, int y) { return scene(kWidth - 1 - x, y); }), {});
  const auto upside_down = flatten(picture([&](int x, int y) { return scene(x, kHeight - 1 - y); }), {});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_NEAR(grey(sideways, kWidth - 1 - x, y), grey(flat, x, y), 0.3) << x << ", " << y;
      EXPECT_NEAR(grey(upside_down, x, kHeight - 1 - y), grey(flat, x, y), 0.3) << x << ", " << y;
    }
}

TEST(Flatten, TheSameBytesAtAnyThreadCount) {
  const auto scene = picture([](int x, int y) { return 128 + 100 * std::sin(x * 0.05) * std::sin(y * x * 0.001); });
  Job four;
  four.threads = 4;
  EXPECT_EQ(flatten(scene, {}).samples, flatten(scene, four).samples);
}

TEST(Flatten, TakesPicturesOfOnePixel) {
  EXPECT_EQ(flatten(Plane<uint16_t>(1, 1, 255 * kSampleScale), {}).samples.size(), 1u);
}

}  // namespace
}  // namespace ldp::rectification
