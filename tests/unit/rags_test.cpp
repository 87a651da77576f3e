#include "core/export/rags.h"

#include <gtest/gtest.h>

#include <utility>

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

Plane<uint8_t> trimmed(Plane<uint8_t> present) {
  trim_rags(present);
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
  const Plane<uint8_t> body = with_box(nothing(), 10, 40, 60, 80);
  EXPECT_EQ(trimmed(with_box(body, 0, 0, kWidth, kThread_px)), body);
}

TEST(TrimRags, WhereThreadsAreAllThereIsTheyStay) {
  Plane<uint8_t> threads = nothing();
  for (int y = 10; y + 2 * kThread_px < 80; y += 2 * kThread_px + 2)
    threads = with_box(threads, 10, y, 100, y + 2 * kThread_px);
  EXPECT_EQ(trimmed(threads), threads);
}

TEST(TrimRags, TakesIslandsAwayAndLeavesWhatIsLarge) {
  const int width = 600, height = 400;  // an island has fewer than 120 pixels
  const auto least = static_cast<int>(kIsland * width * height);
  const int rows = 2 * kThread_px + 1;
  const auto island = [&](int columns) { return with_box({width, height}, 100, 50, 100 + columns, 50 + rows); };
  const Plane<uint8_t> mainland = with_box({width, height}, 300, 0, width, height);
  EXPECT_EQ(trimmed(with_box(mainland, 100, 50, 100 + least / rows, 50 + rows)), mainland);
  EXPECT_EQ(trimmed(island(least / rows + 1)), island(least / rows + 1));
}

TEST(TrimRags, AddsNothingAndKeepsTheValuesOfWhatStays) {
  Plane<uint8_t> present = with_box(nothing(), 10, 10, 60, 80);
  for (uint8_t& sample : present.samples) sample = sample != 0 ? 255 : 0;
  EXPECT_EQ(trimmed(present), present);
  EXPECT_EQ(trimmed(nothing()), nothing());
  EXPECT_EQ(trimmed(Plane<uint8_t>(1, 1, 255)), Plane<uint8_t>(1, 1, 255));
}

TEST(BeyondBorder, HolesAreNotBeyondWhatReachesTheEdgeIs) {
  Plane<uint8_t> present = with_box(nothing(), 20, 20, 100, 70);
  const auto make_absent = [&](int left, int top, int right, int bottom) {
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) present.at(x, y) = 0;
  };
  make_absent(40, 30, 50, 40);
  make_absent(60, 50, 61, 70);
  const Plane<uint8_t> beyond = beyond_border(present);
  EXPECT_EQ(beyond.at(45, 35), 0) << "a hole";
  EXPECT_EQ(beyond.at(60, 50), 1) << "the end of a slit";
  EXPECT_EQ(beyond.at(30, 30), 0);
  for (const int x : {0, 10, kWidth - 1})
    for (const int y : {0, 45, kHeight - 1}) EXPECT_EQ(beyond.at(x, y), 1) << x << ", " << y;
  for (const auto& [x, y] : {std::pair{0, 45}, {kWidth - 1, 45}, {60, 0}, {60, kHeight - 1}}) {
    Plane<uint8_t> notched(kWidth, kHeight, 1);
    notched.at(x, y) = 0;
    EXPECT_EQ(beyond_border(notched).at(x, y), 1) << "at the edge, " << x << ", " << y;
  }
  EXPECT_EQ(beyond_border(nothing()), Plane<uint8_t>(kWidth, kHeight, 1));
  EXPECT_EQ(beyond_border(Plane<uint8_t>(kWidth, kHeight, 255)), nothing());
}

}  // namespace
}  // namespace ldp
