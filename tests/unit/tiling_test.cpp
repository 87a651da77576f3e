// Windows that a grid is cut into: whatever its size, every pixel has one core.
#include "core/solve/tiling.h"

#include <gtest/gtest.h>

#include <vector>

namespace ldp::solve {
namespace {

constexpr int kLengths[] = {1, 2, 3, 17, 63, 64, 65, 100, 129, 500, 1001};

struct Cut {
  int core_px, margin_px;
  bool shift;
};
constexpr Cut kCuts[] = {{64, 8, false}, {64, 8, true}, {16, 0, false}, {16, 5, true}, {7, 3, false}, {200, 20, true}};

TEST(TilingOfALine, GivesEveryPixelOneCoreAndWindowsStayInside) {
  for (const int length : kLengths)
    for (const auto& [core_px, margin_px, shift] : kCuts) {
      std::vector<int> cores(static_cast<size_t>(length), 0);
      for (const Interval& i : tile_line(length, core_px, margin_px, shift)) {
        EXPECT_GE(i.begin, 0);
        EXPECT_LE(i.begin + i.size, length);
        EXPECT_LE(i.begin, i.core_begin);
        EXPECT_GE(i.begin + i.size, i.core_begin + i.core_size);
        EXPECT_LE(i.core_begin - i.begin, margin_px);
        for (int p = i.core_begin; p < i.core_begin + i.core_size; ++p) ++cores[static_cast<size_t>(p)];
      }
      for (int p = 0; p < length; ++p) EXPECT_EQ(cores[static_cast<size_t>(p)], 1) << p << " of " << length;
    }
}

TEST(TilingOfALine, HasPartsOfAboutTheSizeAskedForAndMovesByHalfOfOne) {
  const std::vector<Interval> plain = tile_line(1000, 64, 8, false), shifted = tile_line(1000, 64, 8, true);
  EXPECT_EQ(plain.size(), 16U);
  EXPECT_EQ(shifted.size(), 17U);
  for (const Interval& i : plain) EXPECT_NEAR(i.core_size, 64, 3);
  EXPECT_NEAR(shifted[0].core_size, 31, 2) << "half a part at either end";
  EXPECT_NEAR(shifted[16].core_size, 31, 2);
  for (size_t i = 1; i + 1 < shifted.size(); ++i)
    EXPECT_NEAR(shifted[i].core_begin, (plain[i - 1].core_begin + plain[i].core_begin) / 2.0, 2);
}

TEST(TilingOfARing, GivesEveryPixelOneCoreAndGoesOnPastTheEnd) {
  for (const int length : kLengths) {
    if (length < 17) continue;  // rings have two parts at least
    for (const auto& [core_px, margin_px, shift] : kCuts) {
      if (2 * margin_px + core_px >= length) continue;
      std::vector<int> cores(static_cast<size_t>(length), 0);
      for (const Interval& i : tile_ring(length, core_px, margin_px, shift)) {
        EXPECT_TRUE(i.begin >= 0 && i.begin < length);
        EXPECT_LT(i.size, length);
        for (int p = i.core_begin; p < i.core_begin + i.core_size; ++p) {
          ++cores[static_cast<size_t>(p % length)];
          const int from_begin = ((p - i.begin) % length + length) % length;
          EXPECT_LT(from_begin, i.size) << "a core outside its window";
        }
      }
      for (int p = 0; p < length; ++p) EXPECT_EQ(cores[static_cast<size_t>(p)], 1) << p << " of " << length;
    }
  }
}

TEST(Tilings, LeaveRoomBetweenWindowsThatAreSolvedAtATime) {
  for (const bool shift : {false, true}) {
    const std::vector<Interval> line = tile_line(1000, 64, 20, shift);
    for (size_t i = 0; i + 2 < line.size(); ++i) EXPECT_GE(line[i + 2].begin, line[i].begin + line[i].size + 2);
    const std::vector<Interval> ring = tile_ring(1000, 64, 20, shift);
    for (size_t i = 1; i + 3 < ring.size(); ++i) {
      if (ring[i + 2].begin < ring[i].begin) continue;
      EXPECT_GE(ring[i + 2].begin, ring[i].begin + ring[i].size + 2);
    }
  }
}

}  // namespace
}  // namespace ldp::solve
