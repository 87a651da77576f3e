// Depth maps put onto planes, and without steps that photographs do not show.
#include "core/layers/simpler_maps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <vector>

#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"
#include "tests/unit/square_before_sky.h"

namespace ldp {
namespace {

using namespace test;

int steps(const PanoramaGrid& grid, double parallax_px) {
  return static_cast<int>(layers::parallax_steps(grid, parallax_px));
}

// Farther to the right, nearer below.
DisparityMap slanted(const PanoramaGrid& grid) {
  DisparityMap map(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) map.at(x, y) = static_cast<uint16_t>(1500 - 5 * x + 3 * y);
  return map;
}

// Two thirds of the pixels are off by a pixel of parallax, one way or the other.
DisparityMap noisy(const PanoramaGrid& grid, DisparityMap map) {
  const int off = steps(grid, 1);
  std::minstd_rand random;
  for (uint16_t& disparity : map.samples)
    disparity = static_cast<uint16_t>(disparity + off * (static_cast<int>(random() % 3) - 1));
  return map;
}

double mean_difference(const DisparityMap& a, const DisparityMap& b) {
  double sum = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) sum += std::abs(a.samples[i] - b.samples[i]);
  return sum / static_cast<double>(a.samples.size());
}

DisparityMap on_planes(const PanoramaGrid& grid, DisparityMap map, const Job& job = {}) {
  put_onto_planes(grid, job, map);
  return map;
}

TEST(PutOntoPlanes, TakesNoiseOffASlantedPlane) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap truth = slanted(grid);
  const DisparityMap map = noisy(grid, truth);
  EXPECT_LE(mean_difference(on_planes(grid, map), truth), mean_difference(map, truth) / 6);
}

// Squares of planes fit a whole number of times into none of them.
TEST(PutOntoPlanes, TakesNoiseOffRoundTheSeamAndOffSmallMaps) {
  const PanoramaGrid round = closed_grid(0);
  PanoramaGrid small = simple_grid(0.5), narrow = closed_grid(0);
  small.width = 30, small.height = 10;
  narrow.width = 20;
  narrow.theta_pitch = 2 * std::numbers::pi / narrow.width;
  for (const PanoramaGrid& grid : {round, small, narrow}) {
    const DisparityMap level(grid.width, grid.height, 1000);
    const DisparityMap map = noisy(grid, level);
    EXPECT_LE(mean_difference(on_planes(grid, map), level), mean_difference(map, level) / 3) << grid.width;
    const DisparityMap absent(grid.width, grid.height, kNoDisparity);
    EXPECT_EQ(on_planes(grid, absent), absent);
  }
}

TEST(PutOntoPlanes, LeavesOtherSurfacesAndWhatIsAbsent) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap map = slanted(grid);
  const auto nearer = static_cast<uint16_t>(steps(grid, 10));
  for (int y = 20; y < 30; ++y)
    for (int x = 40; x < 46; ++x) map.at(x, y) = static_cast<uint16_t>(map.at(x, y) + nearer);
  for (int y = 0; y < 5; ++y) map.at(60, y) = kNoDisparity;
  const DisparityMap found = on_planes(grid, map);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) EXPECT_NEAR(found.at(x, y), map.at(x, y), 1) << x << ", " << y;
}

TEST(PutOntoPlanes, LeavesWhatLiesOnNoPlane) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap map(grid.width, grid.height);
  std::minstd_rand random;
  for (uint16_t& disparity : map.samples) disparity = static_cast<uint16_t>(random() % kDisparitySteps);
  EXPECT_EQ(on_planes(grid, map), map);
}

TEST(PutOntoPlanes, IsTheSameRoundTheSeamOnAnyNumberOfThreads) {
  PanoramaGrid grid = closed_grid(0);
  grid.width = 13 * layers::tuning::kPlaneSquarePx;
  grid.theta_pitch = 2 * std::numbers::pi / grid.width;
  DisparityMap map = noisy(grid, DisparityMap(grid.width, grid.height, 1000));
  for (int y = 0; y < grid.height; ++y)  // as much to the left of the seam as to the right
    for (int x = 0; x < grid.width; ++x)
      if ((x + 13) % grid.width < 26) map.at(x, y) = static_cast<uint16_t>(map.at(x, y) + steps(grid, 5));
  const DisparityMap found = on_planes(grid, map);
  const int half = 6 * layers::tuning::kPlaneSquarePx;
  EXPECT_EQ(on_planes(grid, rotated(map, half)), rotated(found, half));
  Job threads;
  threads.threads = 3;
  EXPECT_EQ(on_planes(grid, map, threads), found);
}

// The left half of what is far away nearer by so much parallax.
DisparityMap torn(const PanoramaGrid& grid, double parallax_px) {
  DisparityMap map(grid.width, grid.height, 400);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width / 2; ++x) map.at(x, y) = static_cast<uint16_t>(400 + steps(grid, parallax_px));
  return map;
}

// What is far away, of one grey, but for a stripe of four columns that is lighter by so much, so many columns to the
// right of the middle.
std::vector<UprightFrame> striped(const PanoramaGrid& grid, int lighter, int right = 0) {
  const auto shown = [&](const Eigen::Vector3d&, const Eigen::Vector3d& ray) {
    const double column = (grid.theta_left - std::atan2(ray.y(), ray.x())) / grid.theta_pitch;
    return std::abs(column - grid.width / 2.0 - right) < 2 ? 100.0 + lighter : 100.0;
  };
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 3; ++i) frames.push_back(photograph(0.25 - 0.25 * i, i, shown));
  return frames;
}

int largest_step(const DisparityMap& map) {
  int most = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x + 1 < map.width; ++x) most = std::max(most, std::abs(map.at(x, y) - map.at(x + 1, y)));
  return most;
}

DisparityMap closed(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, DisparityMap map,
                    const Job& job = {}) {
  close_plain_tears(grid, frames, job, map);
  return map;
}

TEST(ClosePlainTears, MakesASlopeOfAStepThatNoPhotoShows) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map = torn(grid, 10), found = closed(grid, striped(grid, 0), map);
  EXPECT_LE(largest_step(found), largest_step(map) / 12);
  const int reach = layers::tuning::kSlopePx + 1;
  for (const int x : {0, grid.width / 2 - reach - 1, grid.width / 2 + reach, grid.width - 1})
    EXPECT_EQ(found.at(x, grid.height / 2), map.at(x, grid.height / 2)) << x;
}

TEST(ClosePlainTears, LeavesStepsThatPhotosShowAndSmallOnes) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map = torn(grid, 10);
  EXPECT_EQ(closed(grid, striped(grid, 40), map), map);
  EXPECT_EQ(closed(grid, striped(grid, 40, 7), map), map);
  EXPECT_EQ(closed(grid, striped(grid, 40, 10), map), map);  // beside the right one of the step's two sides
  EXPECT_NE(closed(grid, striped(grid, 40, 12), map), map);
  EXPECT_NE(closed(grid, striped(grid, 8), map), map);
  const DisparityMap small = torn(grid, 5);
  EXPECT_EQ(closed(grid, striped(grid, 0), small), small);
}

TEST(ClosePlainTears, DrawsNothingTowardsWhatHasAnEdge) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap map = torn(grid, 7);
  const int edge = grid.width / 2 + 13, outline = edge - 6, nearest = map.at(0, 0);
  for (int y = 0; y < grid.height; ++y)
    for (int x = outline; x < grid.width; ++x) map.at(x, y) = static_cast<uint16_t>(400 + steps(grid, 14));
  const DisparityMap found = closed(grid, striped(grid, 40, 13), map);
  ASSERT_NE(found, map);
  for (int x = 0; x < outline; ++x) EXPECT_LE(found.at(x, grid.height / 2), nearest) << x;
}

TEST(ClosePlainTears, LeavesWhatIsAbsentOrNotSeen) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap map = torn(grid, 10);
  map.at(grid.width / 2 + 1, 10) = kNoDisparity;
  const DisparityMap found = closed(grid, striped(grid, 0), map);
  EXPECT_EQ(found.at(grid.width / 2 + 1, 10), kNoDisparity);
  EXPECT_LT(found.at(grid.width / 2 + 2, 10), kDisparitySteps);
  std::vector<UprightFrame> blind = striped(grid, 0);
  for (UprightFrame& frame : blind) frame.valid_end = frame.valid_begin;
  EXPECT_EQ(closed(grid, blind, map), map);
}

TEST(ClosePlainTears, IsTheSameRoundTheSeamOnAnyNumberOfThreads) {
  const PanoramaGrid grid = closed_grid(0);
  std::vector<UprightFrame> frames = striped(grid, 0);
  const DisparityMap map = rotated(torn(grid, 10), grid.width / 2);  // one step at the seam, before the cameras
  const DisparityMap found = closed(grid, frames, map);
  const int y = grid.height / 2;
  EXPECT_LE(std::abs(found.at(0, y) - found.at(grid.width - 1, y)), steps(grid, 10) / 12);
  Job threads;
  threads.threads = 3;
  EXPECT_EQ(closed(grid, frames, map, threads), found);
}

}  // namespace
}  // namespace ldp
