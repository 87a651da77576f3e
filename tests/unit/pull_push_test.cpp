#include "core/panorama/pull_push.h"

#include <gtest/gtest.h>

#include "core/base/plane.h"

namespace ldp {
namespace {

TEST(PullPush, AHoleInOneColourTakesIt) {
  Plane<WeightedColour> image(37, 23, {200, 100, 50, 1});
  for (int y = 5; y < 20; ++y)
    for (int x = 0; x < 30; ++x) image.at(x, y) = {};
  fill_by_pull_push(image);
  for (const WeightedColour& c : image.samples) {
    EXPECT_NEAR(c.r, 200, 1e-3);
    EXPECT_NEAR(c.g, 100, 1e-3);
    EXPECT_NEAR(c.b, 50, 1e-3);
    EXPECT_EQ(c.weight, 1);
  }
}

TEST(PullPush, WhatIsKnownStaysAndBetweenTwoColoursLieTheirMixtures) {
  Plane<WeightedColour> image(64, 16);
  for (int y = 0; y < 16; ++y) {
    image.at(0, y) = {10, 0, 0, 1};
    image.at(63, y) = {250, 0, 0, 1};
  }
  fill_by_pull_push(image);
  EXPECT_EQ(image.at(0, 7).r, 10);
  EXPECT_EQ(image.at(63, 7).r, 250);
  for (int x = 1; x < 64; ++x) EXPECT_GE(image.at(x, 7).r, image.at(x - 1, 7).r - 1e-3) << x;
  EXPECT_NEAR(image.at(31, 7).r + image.at(32, 7).r, 260, 1e-2);
}

TEST(PullPush, WhatIsHalfKnownIsMixedWithWhatLiesAround) {
  Plane<WeightedColour> image(32, 32, {100, 100, 100, 1});
  image.at(9, 12) = {200, 200, 200, 0.5F};
  fill_by_pull_push(image);
  EXPECT_GT(image.at(9, 12).r, 150);
  EXPECT_LT(image.at(9, 12).r, 175);
}

TEST(PullPush, NothingKnownIsMidGrey) {
  for (const int side : {1, 5}) {
    Plane<WeightedColour> image(side, side);
    fill_by_pull_push(image);
    for (const WeightedColour& c : image.samples) EXPECT_EQ(c.g, 127);
  }
}

}  // namespace
}  // namespace ldp
