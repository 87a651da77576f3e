// Outlines of near surfaces, cut to what photographs show.
#include "core/layers/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stop_token>

#include "tests/unit/square_before_sky.h"

namespace ldp {
namespace {

using namespace test;

// Beside the square the nearest camera does not always see the sky: its parallax there is up to 3.75 pixels.
TEST(FitOutlines, AreCloseToTheTruthHoweverWideTheWindowsMadeTheSurface) {
  const PanoramaGrid grid = simple_grid(0.5);
  for (const int by_px : {0, 2, 5, 8}) {
    DisparityMap map = fattened_square(grid, by_px);
    fit_outlines(grid, photographs_of_the_square(grid, Plain::nothing), {}, map);
    constexpr int kClosePx = 2;
    int wrong = 0;
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x) {
        const int outside = std::max({kFirst - x, x - kEnd + 1, 20 - y, y - 39});  // how far, in pixels
        if (outside > kClosePx) wrong += map.at(x, y) != 0;
        if (outside < 0) wrong += map.at(x, y) != kNearSteps;
      }
    EXPECT_LE(wrong, 4) << by_px << " px";
  }
}

TEST(FitOutlines, LeaveASurfaceWithoutTextureAsItIs) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap before = fattened_square(grid, 5);
  DisparityMap map = before;
  fit_outlines(grid, photographs_of_the_square(grid, Plain::all), {}, map);
  EXPECT_LE(differing(map, before), 4);  // corners are rounded
}

TEST(FitOutlines, LeaveAbsentPixelsAndWhatOneCameraSees) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap absent(grid.width, grid.height, kNoDisparity);
  absent.at(50, 30) = 0;
  const DisparityMap before = absent;
  fit_outlines(grid, photographs_of_the_square(grid, Plain::nothing), {}, absent);
  EXPECT_EQ(absent, before);
  DisparityMap map = fattened_square(grid, 5);
  const DisparityMap fat = map;
  fit_outlines(grid, {photographs_of_the_square(grid, Plain::nothing)[2]}, {}, map);
  EXPECT_EQ(map, fat);
}

TEST(FitOutlines, AreTheSameAtAnyThreadCountAndStopWhenAsked) {
  const PanoramaGrid grid = simple_grid(0.5);
  const std::vector<UprightFrame> frames = photographs_of_the_square(grid, Plain::nothing);
  DisparityMap one = fattened_square(grid, 5), many = one;
  Job job;
  fit_outlines(grid, frames, job, one);
  job.threads = 4;
  fit_outlines(grid, frames, job, many);
  EXPECT_EQ(one, many);
  std::stop_source source;
  source.request_stop();
  job.stop = source.get_token();
  EXPECT_THROW(fit_outlines(grid, frames, job, many), Cancelled);
}

}  // namespace
}  // namespace ldp
