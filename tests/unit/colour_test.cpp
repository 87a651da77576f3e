#include "colour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <tuple>
#include <vector>

#include "simple_capture.h"

namespace ldp {
namespace {

using test::camera_at, test::FramesInMemory, test::simple_grid, test::upright_of;

constexpr uint16_t kNearSteps = kDisparitySteps;

VisibilityMap map_of(const UprightFrame& frame, uint16_t inverse_z) {
  VisibilityMap map;
  map.inverse_z = Plane<uint16_t>(frame.camera.height, frame.camera.width, inverse_z);
  map.scale = 1e-4;
  map.tolerance = 100;
  return map;
}

TEST(SourceCandidates, TheNearestCameraIsTheCheapest) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, kNearSteps);
  const std::vector<UprightFrame> frames = {upright_of(camera_at(0.2), 0), upright_of(camera_at(0), 1),
                                            upright_of(camera_at(-0.1), 2)};
  const SourceCandidates candidates(grid, layer, frames, {}, {});
  uint8_t frame[16];
  uint16_t cost[16];
  ASSERT_EQ(candidates.candidates(50, 30, frame, cost), 3);
  EXPECT_TRUE(std::is_sorted(frame, frame + 3));
  EXPECT_LT(cost[1], cost[2]);
  EXPECT_LT(cost[2], cost[0]);
}

TEST(SourceCandidates, CostIsTheAngleBetweenTheRays) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, kNearSteps);
  ColourOptions options;
  options.off_axis_deg = 0;
  const std::vector<UprightFrame> frames = {upright_of(camera_at(0.2), 0)};
  const SourceCandidates candidates(grid, layer, frames, {}, options);
  uint8_t frame[16];
  uint16_t cost[16];
  ASSERT_EQ(candidates.candidates(50, 30, frame, cost), 1);
  const double theta = grid.theta(50.5);
  const Eigen::Vector3d ray = grid.direction(theta, grid.v(30.5));
  const Eigen::Vector3d seen = grid.point(theta, grid.v(30.5), 0.5) - camera_at(0.2).pose.centre;
  const double degrees = std::acos(ray.normalized().dot(seen.normalized())) * 57.29578;
  EXPECT_NEAR(cost[0] / 64.0, degrees, 0.05);
}

TEST(SourceCandidates, AHiddenVoxelHasNoCandidateUnlessGuessed) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  const std::vector<UprightFrame> frames = {upright_of(camera_at(0), 0)};
  const std::vector<VisibilityMap> maps = {map_of(frames[0], 5000)};
  uint8_t frame[16];
  uint16_t cost[16];
  EXPECT_EQ(SourceCandidates(grid, layer, frames, maps, {}).candidates(50, 30, frame, cost), 0);
  ColourOptions guess;
  guess.guess_hidden = true;
  EXPECT_EQ(SourceCandidates(grid, layer, frames, maps, guess).candidates(50, 30, frame, cost), 1);
}

TEST(SourceCandidates, ASampleBesideANearerSurfaceCostsMore) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  const std::vector<UprightFrame> frames = {upright_of(camera_at(0), 0)};
  std::vector<VisibilityMap> maps = {map_of(frames[0], 1)};
  uint8_t frame[16];
  uint16_t clean[16], mixed[16];
  ASSERT_EQ(SourceCandidates(grid, layer, frames, maps, {}).candidates(50, 30, frame, clean), 1);
  for (int column = 71; column < 80; ++column)  // the voxel falls on column 70
    for (int row = 0; row < 80; ++row) maps[0].inverse_z.at(row, column) = 5000;
  ASSERT_EQ(SourceCandidates(grid, layer, frames, maps, {}).candidates(50, 30, frame, mixed), 1);
  EXPECT_EQ(mixed[0], clean[0] + 64 * 8);
}

// Three cameras around the ray, the middle one's picture of its own grey and tint.
std::array<uint16_t, 3> costs_of_three(uint8_t grey, uint8_t odd_grey, uint8_t odd_tint) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, kNearSteps);
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 3; ++i) {
    frames.push_back(upright_of(camera_at(0.1 * (1 - i)), i));
    auto &greys = frames.back().columns.samples, &tints = frames.back().tint.samples;
    std::fill(greys.begin(), greys.end(), i == 1 ? odd_grey : grey);
    std::fill(tints.begin(), tints.end(), i == 1 ? odd_tint : uint8_t{128});
  }
  uint8_t frame[16];
  uint16_t cost[16] = {};
  EXPECT_EQ(SourceCandidates(grid, layer, frames, {}, {}).candidates(50, 30, frame, cost), 3);
  return {cost[0], cost[1], cost[2]};
}

TEST(SourceCandidates, ASampleThatDiffersFromMostCostsMoreTheMoreItDiffers) {
  const auto same = costs_of_three(100, 100, 128), noisy = costs_of_three(100, 103, 126);
  EXPECT_EQ(noisy, same);
  for (const auto& [grey, tint, levels] : {std::tuple{113, 128, 10}, {87, 128, 10}, {100, 111, 14}, {113, 141, 20}}) {
    const auto odd = costs_of_three(100, static_cast<uint8_t>(grey), static_cast<uint8_t>(tint));
    EXPECT_EQ(odd[1], same[1] + 160 * levels);
    EXPECT_EQ(odd[0], same[0]);
    EXPECT_EQ(odd[2], same[2]);
  }
  EXPECT_EQ(costs_of_three(0, 255, 128)[1], same[1] + 160 * 60);
}

TEST(SourceCandidates, TwoThatDifferDoNotOutvoteEachOther) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, kNearSteps);
  std::vector<UprightFrame> frames = {upright_of(camera_at(0.1), 0), upright_of(camera_at(-0.1), 1)};
  uint8_t frame[16];
  uint16_t same[16], differing[16];
  ASSERT_EQ(SourceCandidates(grid, layer, frames, {}, {}).candidates(50, 30, frame, same), 2);
  std::fill(frames[1].columns.samples.begin(), frames[1].columns.samples.end(), uint8_t{200});
  ASSERT_EQ(SourceCandidates(grid, layer, frames, {}, {}).candidates(50, 30, frame, differing), 2);
  EXPECT_TRUE(std::equal(same, same + 2, differing));
}

TEST(SourceCandidates, OfManyCamerasTheEightNearestToTheRayStayInOrder) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, kNearSteps);
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 24; ++i) frames.push_back(upright_of(camera_at(0.24 - 0.02 * i), i));
  const SourceCandidates candidates(grid, layer, frames, {}, {});
  uint8_t frame[16];
  uint16_t cost[16];
  ASSERT_EQ(candidates.candidates(50, 30, frame, cost), 8);
  EXPECT_TRUE(std::is_sorted(frame, frame + 8));
  EXPECT_NEAR(frame[0], 8, 1);
  EXPECT_NE(std::find(frame, frame + 8, 12), frame + 8);
  EXPECT_EQ(std::find(frame, frame + 8, 23), frame + 8);
}

RgbImage ramp() {
  RgbImage image(140, 80);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 140; ++x) image.at(x, y) = {static_cast<uint8_t>(x), static_cast<uint8_t>(2 * y), 77};
  return image;
}

TEST(FetchColours, ReadsAPhotographWhereTheCameraProjectsTheVoxel) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, kNearSteps);
  const Plane<uint8_t> source(grid.width, grid.height, 0);
  RgbImage colour(grid.width, grid.height);
  const FramesInMemory frames({ramp()});
  std::vector<Camera> cameras = {camera_at(0.05)};
  cameras[0].intrinsics.k1 = 0.1;
  fetch_colours(grid, {frames, cameras, {0}, {{1, 1, 1}}}, {{&layer, &source, &colour}}, {}, {});
  for (const auto& [x, y] : {std::pair{40, 20}, {55, 41}, {60, 10}}) {
    const Eigen::Vector3d p = grid.point(grid.theta(x + 0.5), grid.v(y + 0.5), 0.5) - cameras[0].pose.centre;
    const Eigen::Vector2d at = project(cameras[0].intrinsics, cameras[0].pose.world_from_camera.transpose() * p);
    EXPECT_NEAR(colour.at(x, y).r, at.x() - 0.5, 0.6);
    EXPECT_NEAR(colour.at(x, y).g, 2 * (at.y() - 0.5), 0.6);
    EXPECT_EQ(colour.at(x, y).b, 77);
  }
}

TEST(FetchColours, AppliesTheGainOfEachChannel) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  const Plane<uint8_t> source(grid.width, grid.height, 0);
  RgbImage colour(grid.width, grid.height);
  const FramesInMemory frames({RgbImage(140, 80, {100, 100, 50})});
  const std::vector<Camera> cameras = {camera_at(0)};
  fetch_colours(grid, {frames, cameras, {0}, {{0.5F, 1.25F, 2}}}, {{&layer, &source, &colour}}, {}, {});
  EXPECT_EQ(colour.at(50, 30), (Rgb{50, 125, 100}));
}

// A wall that photographs taken one after another show in these levels, where the panorama takes the one at `chosen`.
Rgb averaged(const std::vector<uint8_t>& levels, uint8_t chosen, int noise_range, double last_theta = 0) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  const Plane<uint8_t> source(grid.width, grid.height, chosen);
  RgbImage colour(grid.width, grid.height);
  std::vector<RgbImage> photos;
  std::vector<Camera> cameras;
  std::vector<int> frame_of_camera;
  for (const uint8_t level : levels) {
    photos.emplace_back(140, 80, Rgb{level, 50, 60});
    frame_of_camera.push_back(static_cast<int>(cameras.size()));
    cameras.push_back(camera_at(0.01 * static_cast<double>(cameras.size())));
  }
  if (last_theta > 0) cameras.back() = camera_at(last_theta);
  const std::vector<std::array<float, 3>> gains(cameras.size(), {1, 1, 1});
  fetch_colours(grid, {FramesInMemory(photos), cameras, frame_of_camera, gains, noise_range},
                {{&layer, &source, &colour}}, {}, {});
  return colour.at(50, 30);
}

TEST(FetchColours, NoisyPhotographsAreAveragedWithThoseTakenBesideThem) {
  EXPECT_EQ(averaged({100, 104, 105}, 1, 5), (Rgb{103, 50, 60}));
  EXPECT_EQ(averaged({100, 104, 105}, 1, 0), (Rgb{104, 50, 60}));
}

TEST(FetchColours, WhatNoiseDoesNotExplainIsAnotherSurface) {
  EXPECT_EQ(averaged({100, 104, 140}, 1, 5), (Rgb{102, 50, 60}));
}

TEST(FetchColours, PhotographsTakenLongBeforeOrElsewhereAreNoCompanions) {
  EXPECT_EQ(averaged({104, 100, 100, 100}, 3, 5), (Rgb{100, 50, 60}));
  EXPECT_EQ(averaged({100, 104}, 0, 5, 2.5), (Rgb{100, 50, 60}));
}

TEST(NoiseRange, FollowsThePhotographInTheMiddleAndIsNoneForCleanOnes) {
  std::vector<UprightFrame> frames(3);
  frames[0].noise = 2, frames[1].noise = 40, frames[2].noise = 3;
  ColourOptions options;
  options.noise_range = 5;
  EXPECT_EQ(noise_range(frames, options), 15);
  for (UprightFrame& frame : frames) frame.noise = 0.5F;
  EXPECT_EQ(noise_range(frames, options), 0);
  EXPECT_EQ(noise_range({}, options), 0);
}

// Two photographs of one grey wall, the second brighter, meet at column `border` of the panorama.
RgbImage two_exposures(bool even, int border) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  Plane<uint8_t> source(grid.width, grid.height, 0);
  for (int y = 0; y < grid.height; ++y)
    for (int x = border; x < grid.width; ++x) source.at(x, y) = 1;
  RgbImage colour(grid.width, grid.height);
  const FramesInMemory frames({RgbImage(140, 80, {100, 100, 100}), RgbImage(140, 80, {116, 100, 100})});
  const std::vector<Camera> cameras = {camera_at(0.02), camera_at(-0.02)};
  ColourOptions options;
  options.even_seams = even;
  fetch_colours(grid, {frames, cameras, {0, 1}, {{1, 1, 1}, {1, 1, 1}}}, {{&layer, &source, &colour}}, options, {});
  return colour;
}

TEST(EvenSeams, AStepBetweenTwoExposuresIsSpreadOverBothSides) {
  for (const int x : {50, 48}) {  // within a cell, and between two
    const RgbImage hard = two_exposures(false, x), even = two_exposures(true, x);
    EXPECT_EQ(hard.at(x, 30).r - hard.at(x - 1, 30).r, 16);
    EXPECT_LE(std::abs(even.at(x, 30).r - even.at(x - 1, 30).r), 2);
    EXPECT_GT(even.at(x - 1, 30).r, 103);
    EXPECT_LT(even.at(x, 30).r, 113);
    EXPECT_EQ(even.at(x - 1, 30).g, 100);
  }
}

}  // namespace
}  // namespace ldp
