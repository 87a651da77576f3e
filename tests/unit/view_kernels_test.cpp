#include "core/layers/painting/view_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace ldp::layers::kernels {
namespace {

constexpr int kMost = 37;
constexpr size_t kRoom = kMost + 1 + kPadding;

// A column of disparities, some absent, some joined to those beside them, before a camera that looks at it askew.
struct Column {
  std::array<uint16_t, kRoom> here{}, left{}, right{};
  std::array<uint8_t, kRoom> joined_left{}, joined_right{};
  std::array<float, kRoom> edges_v{};
  ColumnInView view{};

  explicit Column(unsigned seed) {
    std::mt19937 random(seed);
    for (size_t i = 0; i < kRoom; ++i) {
      edges_v[i] = 0.4F - 0.02F * static_cast<float>(i);
      here[i] = random() % 7 == 0 ? kAbsent : static_cast<uint16_t>(random() % 3826);
      left[i] = static_cast<uint16_t>(random() % 3826);
      right[i] = static_cast<uint16_t>(random() % 3826);
      joined_left[i] = here[i] != kAbsent && random() % 2 == 0;
      joined_right[i] = here[i] != kAbsent && random() % 2 == 0;
    }
    const auto between = [&](float low, float high) {
      return low + (high - low) * static_cast<float>(random() % 1000) / 1000;
    };
    view.inverse_depth = {0.01F, 1 / 7650.F};
    view.forward = {between(0.6F, 1), between(-0.4F, 0.4F)};
    view.forward_left = {view.forward.constant - 0.01F, view.forward.slope};
    view.forward_right = {view.forward.constant + 0.01F, view.forward.slope};
    view.across_left = {between(10, 60), between(-20, 20)};
    view.across_right = {view.across_left.constant + 2, view.across_left.slope};
    view.focal = 90;
    view.cy = 40;
    view.up = between(-0.3F, 0.3F);
    view.columns = 70;
    view.rows = 80;
    view.steps = 9000;
  }
  DisparityColumn disparities() const {
    return {here.data(), left.data(), right.data(), joined_left.data(), joined_right.data()};
  }
};

struct FoundBoxes {
  std::array<std::array<int32_t, kRoom>, 5> rows{};
  FoundBoxes(const Kernels& kernels, const Column& column, int count) {
    kernels.find_boxes(column.disparities(), column.view, column.edges_v.data(), count,
                       {rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data(), rows[4].data()});
  }
};

TEST(ViewKernels, GiveTheSameBoxesOnEveryInstructionSetAtEveryLength) {
  for (unsigned seed = 0; seed < 20; ++seed)
    for (int count = 0; count <= kMost; ++count) {
      const Column column(seed);
      const FoundBoxes best(kernels::best(), column, count), plain(kernels::plain(), column, count);
      for (size_t k = 0; k < 5; ++k)
        for (size_t i = 0; i < static_cast<size_t>(count); ++i)
          ASSERT_EQ(best.rows[k][i], plain.rows[k][i]) << k << ", " << i << " of " << count;
    }
}

// The first pixel whose centre is at or after a position; -1 where rounding decides.
int first_pixel(double position, double limit) {
  const double pixel = position - 0.5;
  if (std::abs(pixel - std::round(pixel)) < 2e-3) return -1;
  return static_cast<int>(std::ceil(std::fmin(std::fmax(pixel, 0), limit)));
}

TEST(ViewKernels, BoxesLieWhereTheirSidesAreProjected) {
  int present = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Column column(seed);
    const ColumnInView& view = column.view;
    const FoundBoxes found(kernels::best(), column, kMost);
    const auto at = [](const Linear& linear, double x) { return linear.constant + linear.slope * x; };
    for (size_t i = 0; i < kMost; ++i) {
      const auto& [begin_x, end_x, begin_y, end_y, inverse_z] = found.rows;
      if (column.here[i] == kAbsent) {
        ASSERT_EQ(end_x[i], 0);
        continue;
      }
      ++present;
      const double d = column.here[i];
      const double w = at(view.inverse_depth, 2 * d),
                   w_left = at(view.inverse_depth, d + (column.joined_left[i] ? column.left[i] : d)),
                   w_right = at(view.inverse_depth, d + (column.joined_right[i] ? column.right[i] : d));
      const double forward = at(view.forward, w);
      const auto row = [&](size_t edge) {
        return first_pixel(view.cy - view.focal * (view.up * w + column.edges_v[edge]) / forward, view.rows);
      };
      const std::array<std::array<int, 2>, 4> sides = {
          {{first_pixel(at(view.across_left, w_left) / at(view.forward_left, w_left), view.columns), begin_x[i]},
           {first_pixel(at(view.across_right, w_right) / at(view.forward_right, w_right), view.columns), end_x[i]},
           {row(i), begin_y[i]},
           {row(i + 1), end_y[i]}}};
      for (const auto& [wanted, is] : sides)
        ASSERT_TRUE(wanted < 0 || is == wanted) << is << " for " << wanted << " of " << seed << ", " << i;
      ASSERT_NEAR(inverse_z[i], w / forward * view.steps, 1.1);
    }
  }
  EXPECT_GT(present, 1000);
}

TEST(ViewKernels, NothingIsDrawnOfWhatIsBehindTheCamera) {
  Column column(1);
  column.view.forward_left = {-0.5F, 0};
  const FoundBoxes found(kernels::best(), column, kMost);
  for (size_t i = 0; i < kMost; ++i) ASSERT_LE(found.rows[1][i], found.rows[0][i]);
}

TEST(ViewKernels, AWitnessSeesASurfaceWhereItIsProjected) {
  std::mt19937 random(7);
  ToWitness to{};
  to.forward = {0.9F, 1e-5F};
  to.across = {30, 2e-3F};
  to.down = -4e-4F;
  to.row = {-20, 0.95F};
  to.width = 64;
  to.height = 48;
  to.cy = 24;
  to.steps = 1.1F;
  to.tolerance = 3;
  std::array<int32_t, kRoom> rows{}, steps{};
  for (size_t i = 0; i < kRoom; ++i)
    rows[i] = static_cast<int>(random() % 60), steps[i] = static_cast<int>(random() % 20000);
  int inside = 0;
  for (int count = 0; count <= kMost; ++count) {
    std::array<std::array<int32_t, kRoom>, 3> best{}, plain{};
    kernels::best().look_from_witness(to, rows.data(), steps.data(), count, best[0].data(), best[1].data(),
                                      best[2].data());
    kernels::plain().look_from_witness(to, rows.data(), steps.data(), count, plain[0].data(), plain[1].data(),
                                       plain[2].data());
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      for (size_t k = 0; k < 3; ++k) ASSERT_EQ(best[k][i], plain[k][i]);
      const double forward = 0.9 + 1e-5 * steps[i], x = (30 + 2e-3 * steps[i]) / forward,
                   y = (-20 + 0.95 * rows[i] - 4e-4 * steps[i]) / forward + 24;
      const bool seen = x >= 0 && x < 64 && y >= 0 && y < 48;
      ASSERT_EQ(best[0][i] >= 0, seen) << x << ", " << y;
      if (!seen) continue;
      ++inside;
      ASSERT_NEAR(best[0][i], 16 * x - 0.5, 0.52);
      ASSERT_NEAR(best[1][i], 16 * y - 0.5, 0.52);
      ASSERT_NEAR(best[2][i], std::fmin(steps[i] * 1.1 / forward, 65535) + 3 - 0.5, 0.6);
    }
  }
  EXPECT_GT(inside, 200);
}

}  // namespace
}  // namespace ldp::layers::kernels
