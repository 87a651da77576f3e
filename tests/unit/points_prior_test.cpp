#include "core/sweep/points_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/unit/simple_capture.h"

namespace ldp::sweep {
namespace {

using test::simple_grid;

PanoramaGrid wide_grid() {
  PanoramaGrid grid = simple_grid(0.6);
  grid.width = 256, grid.height = 200;
  grid.theta_left = 0.5 * grid.width * grid.theta_pitch;
  return grid;
}

ScenePoint point_at(const PanoramaGrid& grid, double x_px, double y_px, double label, int cameras = 2) {
  const double w = grid.w_far + (grid.w_near - grid.w_far) * label / 15;
  return {grid.point(grid.theta(x_px), grid.v(y_px), w), std::vector<int>(static_cast<size_t>(cameras), 0)};
}

TEST(PointsPrior, TellsTheLabelOfAPointLessAndLessFurtherAway) {
  const PanoramaGrid grid = wide_grid();
  const PointsPrior prior(grid, {point_at(grid, 100, 36, 6.25)}, 16);
  EXPECT_EQ(prior.at(100, 36).label, 100);
  EXPECT_EQ(prior.at(100, 36).weight, 256);
  EXPECT_EQ(prior.at(124, 36).weight, 64);
  EXPECT_EQ(prior.at(124, 36).label, 100);
  EXPECT_EQ(prior.at(196, 36).weight, 0);
  EXPECT_EQ(prior.at(100, 132).weight, 0);
}

TEST(PointsPrior, IsTheMedianOfWhatManyCamerasSaw) {
  const PanoramaGrid grid = wide_grid();
  const auto among = [&](int cameras) {
    return PointsPrior(grid,
                       {point_at(grid, 100, 36, 4), point_at(grid, 100, 36, 4.5), point_at(grid, 100, 36, 10, cameras)},
                       16)
        .at(100, 36);
  };
  EXPECT_EQ(among(2).label, 72);
  EXPECT_EQ(among(4).label, 160);
  EXPECT_EQ(among(9).label, 160);
}

TEST(PointsPrior, PointsThatDisagreeTellLittle) {
  const PanoramaGrid grid = wide_grid();
  const auto weight = [&](double apart) {
    return PointsPrior(grid, {point_at(grid, 100, 36, 5), point_at(grid, 100, 36, 5 + apart)}, 16).at(100, 36).weight;
  };
  EXPECT_EQ(weight(0), 256);
  EXPECT_EQ(weight(0.6), 128);
  EXPECT_LT(weight(6), 4);
}

TEST(PointsPrior, KnowsNothingWithoutPointsOrDepthsAndLeavesOutWhatLiesOutside) {
  PanoramaGrid grid = wide_grid();
  EXPECT_EQ(PointsPrior(grid, {}, 16).at(10, 10).weight, 0);
  EXPECT_EQ(PointsPrior(grid, {point_at(grid, 100, 36, 18)}, 16).at(100, 36).weight, 0);
  EXPECT_EQ(PointsPrior(grid, {point_at(grid, 100, 36, 15.5)}, 16).at(100, 36).label, 240);
  const ScenePoint inside = point_at(grid, 100, 36, 5);
  grid.w_near = grid.w_far = 0;
  EXPECT_EQ(PointsPrior(grid, {inside}, 16).at(100, 36).weight, 0);
}

TEST(PointsPrior, ReachesInFromBeyondTheBordersAndAcrossTheSeam) {
  PanoramaGrid grid = wide_grid();
  EXPECT_EQ(PointsPrior(grid, {point_at(grid, -20, 36, 6)}, 16).at(4, 36).weight, 64);
  EXPECT_EQ(PointsPrior(grid, {point_at(grid, 276, 36, 6)}, 16).at(252, 36).weight, 64);
  grid.theta_pitch = 2 * std::acos(-1.0) / grid.width;
  grid.wraps = true;
  const PointsPrior prior(grid, {point_at(grid, 4, 36, 6)}, 16);
  EXPECT_GT(prior.at(252, 36).weight, 150);
  EXPECT_EQ(prior.at(256 + 4, 36).weight, prior.at(4, 36).weight);
}

}  // namespace
}  // namespace ldp::sweep
