#include "core/poses/features/sift_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <random>
#include <vector>

namespace ldp::sfm::sift {
namespace {

std::vector<float> random_numbers(size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<float> numbers(count);
  for (float& number : numbers) number = static_cast<float>(random() % 65536) / 256;
  return numbers;
}

constexpr float kHalf[] = {0.4F, 0.2F, 0.08F, 0.02F};
constexpr Blur kBlur = {kHalf, 3};
constexpr int kWidest = 75;

TEST(SiftKernels, BlurRowsOfEveryWidthAsTheSumSays) {
  const std::vector<float> line = random_numbers(kWidest + 6, 1);
  for (const Kernels* kernels : {&best(), &plain()}) {
    for (int width = 1; width <= kWidest; ++width) {
      std::vector<const float*> rows;  // row j is the line from place j on, so that both blurs are one
      for (int j = 0; j <= 6; ++j) rows.push_back(line.data() + j);
      std::vector<float> down(kWidest, -1), across(kWidest, -1);
      kernels->blur_down(rows.data(), kBlur, width, down.data());
      kernels->blur_across(line.data() + 3, kBlur, width, across.data());
      EXPECT_EQ(down, across);
      for (int x = 0; x < kWidest; ++x) {
        float sum = kHalf[0] * line[static_cast<size_t>(x + 3)];
        for (int j = 1; j <= 3; ++j)
          sum += kHalf[j] * (line[static_cast<size_t>(x + 3 - j)] + line[static_cast<size_t>(x + 3 + j)]);
        EXPECT_EQ(down[static_cast<size_t>(x)], x < width ? sum : -1) << x << " of " << width;
      }
    }
  }
}

TEST(SiftKernels, MarkWhatNothingOfThreeByThreeByThreeIsBeyond) {
  constexpr size_t kRow = kWidest;
  constexpr float kLeast = 20;
  const std::vector<float> samples = random_numbers(4 * 3 * kRow, 2);  // 3 rows each of 4 pictures
  const auto row = [&](size_t picture, size_t y) { return samples.data() + (3 * picture + y) * kRow; };
  for (const Kernels* kernels : {&best(), &plain()}) {
    std::vector<float> found(9 * kRow);
    DifferenceRow levels[3];
    for (size_t i = 0; i < 3; ++i) {
      levels[i] = {&found[3 * i * kRow], &found[(3 * i + 1) * kRow], &found[(3 * i + 2) * kRow]};
      kernels->find_difference({row(i, 0), row(i, 1), row(i, 2)}, {row(i + 1, 0), row(i + 1, 1), row(i + 1, 2)},
                               kWidest, levels[i]);
    }
    std::vector<uint8_t> marks(kRow);
    kernels->mark_extrema(levels, kLeast, kWidest, marks.data());
    int marked = 0;
    for (size_t x = 1; x + 1 < kRow; ++x) {
      const auto difference = [&](size_t i, size_t y, size_t u) { return row(i + 1, y)[u] - row(i, y)[u]; };
      const float middle = difference(1, 1, x);
      int above = 0, below = 0;
      for (size_t i = 0; i < 3; ++i)
        for (size_t y = 0; y < 3; ++y)
          for (size_t u = x - 1; u <= x + 1; ++u) {
            above += difference(i, y, u) > middle;
            below += difference(i, y, u) < middle;
          }
      const bool extreme = std::abs(middle) > kLeast && (middle > 0 ? above : below) == 0;
      EXPECT_EQ(marks[x], extreme ? 1 : 0) << x;
      marked += marks[x];
    }
    EXPECT_GT(marked, 0);
  }
}

TEST(SiftKernels, KeepPlacesJustShortOfTheEndWithinTheCells) {
  constexpr int kSide = 7;
  const std::vector<float> picture = random_numbers(kSide * kSide, 5), weights(kSide, 1.0F);
  const PatchRotation turn{0, std::nextafter(1.25F, 0.0F), 0};
  ASSERT_LT(turn.sine * 2 + 1.5F, 4.0F);
  ASSERT_EQ(turn.sine * 2 + 1.5F + 1, 5.0F);
  for (const Kernels* kernels : {&best(), &plain()}) {
    struct {
      Cells cells = {};
      float beyond[2 * kPaddedCells * kOrientations];
    } memory;
    std::fill(std::begin(memory.beyond), std::end(memory.beyond), -0.0F);  // even adding nothing would show
    const float* const middle = &picture[static_cast<size_t>(5 * kSide + 3)];
    kernels->add_to_descriptor({middle, kSide, 2, -2, -1, &weights[3]}, turn, memory.cells);
    EXPECT_GT(std::accumulate(std::begin(memory.cells), std::end(memory.cells), 0.0F), 0);
    EXPECT_TRUE(
        std::all_of(std::begin(memory.beyond), std::end(memory.beyond), [](float f) { return std::signbit(f); }));
  }
}

TEST(SiftKernels, AtHandAddTheSameBytesAsThePlainOnes) {
  constexpr int kReach = 38, kSide = 2 * kReach + 3;
  const std::vector<float> picture = random_numbers(kSide * kSide, 3), weights = random_numbers(2 * kReach + 1, 4);
  for (int turn = 0; turn < 12; ++turn) {
    for (const int first : {-kReach, -20, 0}) {
      Cells cells[2] = {};
      float bins[2][kOrientationBins] = {};
      const double angle = 0.5 * turn, per_px = 0.06 + 0.01 * turn;
      const PatchRotation to_cells{static_cast<float>(per_px * std::cos(angle)),
                                   static_cast<float>(per_px * std::sin(angle)), static_cast<float>(angle)};
      for (const int y : {-kReach, -7, 0, 11, kReach}) {
        const float* const middle = &picture[static_cast<size_t>((y + kReach + 1) * kSide + kReach + 1)];
        const WindowRow row{middle, kSide, y, first, kReach + 1 - turn, &weights[kReach]};
        best().add_to_descriptor(row, to_cells, cells[0]);
        plain().add_to_descriptor(row, to_cells, cells[1]);
        best().add_to_orientation_histogram(row, bins[0]);
        plain().add_to_orientation_histogram(row, bins[1]);
      }
      EXPECT_TRUE(std::equal(std::begin(cells[0]), std::end(cells[0]), std::begin(cells[1])));
      EXPECT_TRUE(std::equal(std::begin(bins[0]), std::end(bins[0]), std::begin(bins[1])));
      EXPECT_GT(*std::max_element(std::begin(cells[0]), std::end(cells[0])), 0);
    }
  }
}

}  // namespace
}  // namespace ldp::sfm::sift
