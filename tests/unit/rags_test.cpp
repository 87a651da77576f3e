#include "core/export/rags.h"

#include <gtest/gtest.h>

#include "core/base/plane.h"

namespace ldp {
namespace {

constexpr int kWidth = 120, kHeight = 90;  // an island has at most 5 pixels

Plane<uint8_t> with_box(Plane<uint8_t> present, int left, int top, int right, int bottom) {
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) present.at(x, y) = 1;
  return present;
}

Plane<uint8_t> nothing() { return {kWidth, kHeight}; }

Plane<uint8_t> trimmed(Plane<uint8_t> present, bool wraps = false) {
  trim_rags(present, wraps);
  return present;
}

TEST(TrimRags, LeavesWhatIsWiderThanAThread) {
  const Plane<uint8_t> wide = with_box(nothing(), 40, 30, 40 + 2 * kThread_px + 1, 80);
  EXPECT_EQ(trimmed(wide), wide);
  const Plane<uint8_t> high = with_box(nothing(), 20, 30, 100, 30 + 2 * kThread_px + 1);
  EXPECT_EQ(trimmed(high), high);
  const Plane<uint8_t> all(kWidth, kHeight, 1);
  EXPECT_EQ(trimmed(all), all);
}

TEST(TrimRags, TakesThreadsAwayFromWhatTheyHangFrom) {
  const Plane<uint8_t> body = with_box(nothing(), 10, 10, 60, 80);
  EXPECT_EQ(trimmed(with_box(body, 60, 40, 90, 40 + 2 * kThread_px)), body);
  EXPECT_EQ(trimmed(with_box(body, 20, 80, 20 + 2 * kThread_px, 89)), body);
}

TEST(TrimRags, WhatLiesAlongTheEdgeGoesOnBeyondIt) {
  const Plane<uint8_t> strip = with_box(nothing(), 0, 0, kWidth, kThread_px + 1);
  EXPECT_EQ(trimmed(strip), strip);
  EXPECT_EQ(trimmed(with_box(nothing(), 0, 0, kWidth, kThread_px)), nothing());
}

TEST(TrimRags, WhereItWrapsBothEndsAreSideBySide) {
  const auto ends = [](int left, int right) {
    return with_box(with_box(nothing(), 0, 0, left, kHeight), kWidth - right, 0, kWidth, kHeight);
  };
  EXPECT_EQ(trimmed(ends(2, 2 * kThread_px - 1), true), ends(2, 2 * kThread_px - 1));
  EXPECT_EQ(trimmed(ends(2, 2 * kThread_px - 2), true), nothing());
  EXPECT_EQ(trimmed(ends(kThread_px + 1, 0), true), nothing());
}

TEST(TrimRags, TakesIslandsAwayAndLeavesWhatIsLarge) {
  const int width = 600, height = 400;  // an island has fewer than 120 pixels
  const auto least = static_cast<int>(kIsland * width * height);
  const int rows = 2 * kThread_px + 1;
  const auto island = [&](int columns) { return with_box({width, height}, 100, 50, 100 + columns, 50 + rows); };
  EXPECT_EQ(trimmed(island(least / rows)), Plane<uint8_t>(width, height));
  EXPECT_EQ(trimmed(island(least / rows + 1)), island(least / rows + 1));
}

TEST(TrimRags, AddsNothingAndKeepsTheValuesOfWhatStays) {
  Plane<uint8_t> present = with_box(nothing(), 10, 10, 60, 80);
  for (uint8_t& sample : present.samples) sample = sample != 0 ? 255 : 0;
  EXPECT_EQ(trimmed(present), present);
  EXPECT_EQ(trimmed(nothing()), nothing());
  EXPECT_EQ(trimmed(Plane<uint8_t>(1, 1, 255), true), Plane<uint8_t>(1, 1, 255));
}

}  // namespace
}  // namespace ldp
