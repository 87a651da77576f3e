#include "core/colour/colour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <tuple>
#include <vector>

#include "core/colour/blending.h"
#include "core/colour/halved_candidates.h"
#include "tests/unit/simple_capture.h"

namespace ldp::colour {
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
  uint16_t frame[16], cost[16];
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
  uint16_t frame[16], cost[16];
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
  uint16_t frame[16], cost[16];
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
  uint16_t frame[16];
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
  uint16_t frame[16], cost[16] = {};
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
  uint16_t frame[16];
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
  uint16_t frame[16], cost[16];
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
  const SourceMap source(Plane<uint8_t>(grid.width, grid.height, 0));
  RgbImage colour(grid.width, grid.height);
  const FramesInMemory frames({ramp()});
  std::vector<Camera> cameras = {camera_at(0.05)};
  cameras[0].intrinsics.k1 = 0.1;
  blend_colours(grid, {frames, cameras, {0}, {{1, 1, 1}}}, {{&layer, &source, &colour}}, {}, {});
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
  const SourceMap source(Plane<uint8_t>(grid.width, grid.height, 0));
  RgbImage colour(grid.width, grid.height);
  const FramesInMemory frames({RgbImage(140, 80, {100, 100, 50})});
  const std::vector<Camera> cameras = {camera_at(0)};
  blend_colours(grid, {frames, cameras, {0}, {{0.5F, 1.25F, 2}}}, {{&layer, &source, &colour}}, {}, {});
  EXPECT_EQ(colour.at(50, 30), (Rgb{50, 125, 100}));
}

TEST(Agreed, IsTheMeanOfTheMiddleHalfOfEachChannel) {
  const std::vector<Colour> five = {{0, 10, 7}, {100, 11, 7}, {104, 900, 7}, {105, 12, 7}, {4000, 10, 7}};
  EXPECT_EQ(consensus(five), (Colour{103, 11, 7}));
  const std::vector<Colour> seven = {{10, 0, 0}, {1, 0, 0}, {60, 0, 0}, {2, 0, 0}, {90, 0, 0}, {3, 0, 0}, {5, 0, 9}};
  EXPECT_EQ(consensus(seven), (Colour{6, 0, 0}));  // of 3 5 10
  const std::vector<Colour> three = {{90, 0, 0}, {10, 0, 0}, {20, 0, 0}};
  EXPECT_EQ(consensus(three), (Colour{20, 0, 0}));
}

TEST(Agreed, OfTwoThatDifferNeitherIsOutvoted) {
  const std::vector<Colour> two = {{10, 10, 10}, {90, 90, 90}};
  EXPECT_EQ(consensus(two), two[0]);
}

TEST(BrightnessDifferences, AreMediansOfCellsAndBilinearBetweenThem) {
  PanoramaGrid grid;
  grid.width = 200, grid.height = 130;
  BrightnessDifferences differences(grid);
  ASSERT_EQ(differences.columns(), 4);
  ASSERT_EQ(differences.rows(), 3);
  std::vector<Colour> left(9, Colour{-160, 0, 16}), right(9, Colour{320, 0, -16}), few(7, Colour{5000, 5000, 5000});
  for (size_t i = 0; i < 4; ++i) left[i] = {4000, 4000, -4000};  // of other surfaces
  differences.set(0, 1, 2, left);
  differences.set(1, 1, 2, right);
  differences.set(2, 1, 2, few);
  const int middle = 65;
  EXPECT_EQ(differences.at(0, middle, 2), (Colour{-160, 0, 16}));   // nothing further left
  EXPECT_EQ(differences.at(99, middle, 2), (Colour{320, 0, -16}));  // what is not known does not count
  EXPECT_EQ(differences.at(24, middle, 2), (Colour{-160, 0, 16}));  // the middle of a cell
  EXPECT_NEAR(differences.at(37, middle, 2).value()[0], -160 + 480 / 4, 5);
  EXPECT_NEAR(differences.at(50, middle, 2).value()[2], 0, 1);
  EXPECT_EQ(differences.at(190, middle, 2), std::nullopt);
  EXPECT_EQ(differences.at(0, middle, 3), std::nullopt);
  differences.clear();
  EXPECT_EQ(differences.at(0, middle, 2), std::nullopt);
}

TEST(BrightnessDifferences, AreBilinearFromRowToRow) {
  PanoramaGrid grid;
  grid.width = 64, grid.height = 128;
  BrightnessDifferences differences(grid);
  std::vector<Colour> above(8, Colour{0, 0, 0}), below(8, Colour{1280, 0, 0});
  differences.set(0, 0, 0, above);
  differences.set(0, 1, 0, below);
  EXPECT_EQ(differences.at(0, 0, 0).value()[0], 0);
  EXPECT_EQ(differences.at(0, 40, 0).value()[0], 170);
  EXPECT_EQ(differences.at(0, 127, 0).value()[0], 1280);
}

TEST(BrightnessDifferences, GoOnAroundAClosedPanorama) {
  PanoramaGrid grid;
  grid.width = 260, grid.height = 64;  // cells do not divide it
  std::vector<Colour> none(8, Colour{}), some(8, Colour{1600, 1600, 1600});
  for (const bool wraps : {false, true}) {
    grid.wraps = wraps;
    BrightnessDifferences differences(grid);
    ASSERT_EQ(differences.columns(), 5);
    differences.set(4, 0, 0, some);
    EXPECT_EQ(differences.at(0, 32, 0).has_value(), wraps);
    differences.set(0, 0, 0, none);
    const int last = differences.at(259, 32, 0).value()[0], first = differences.at(0, 32, 0).value()[0];
    if (wraps)
      EXPECT_NEAR(last - first, 1600 / 52, 1);  // as between any two columns there
    else
      EXPECT_EQ(last - first, 1600);
  }
}

struct TwoBesideEachOther {
  PanoramaGrid grid = simple_grid(0.5);
  DisparityMap layer{grid.width, grid.height, kNearSteps};
  std::vector<UprightFrame> frames = {upright_of(camera_at(0.01), 0), upright_of(camera_at(-0.01), 1)};
  std::vector<VisibilityMap> maps = {map_of(frames[0], 0), map_of(frames[1], 0)};
};

TEST(HalvedCandidates, ACellHasThoseOfItsFirstPixelThatIsPresent) {
  TwoBesideEachOther two;
  two.layer.at(40, 20) = kNoDisparity;
  two.layer.at(41, 21) = kDisparitySteps / 2;
  for (const auto& [x, y] : {std::pair(60, 30), {61, 30}, {60, 31}, {61, 31}}) two.layer.at(x, y) = kNoDisparity;
  const SourceCandidates whole(two.grid, two.layer, two.frames, {}, {});
  const HalvedCandidates halved(whole);
  EXPECT_EQ(halved.width(), (two.grid.width + 1) / 2);
  EXPECT_EQ(halved.height(), (two.grid.height + 1) / 2);
  uint16_t frame[16], cost[16], expected[16];
  for (const auto& [x, y, from_x, from_y] : {std::tuple(10, 8, 20, 16), {20, 10, 41, 21}}) {
    ASSERT_TRUE(halved.present(x, y));
    ASSERT_EQ(halved.candidates(x, y, frame, cost), 2);
    ASSERT_EQ(whole.candidates(from_x, from_y, frame, expected), 2);
    EXPECT_TRUE(std::equal(cost, cost + 2, expected)) << x;
    EXPECT_EQ(halved.depth_label(x, y), whole.depth_label(from_x, from_y));
  }
  EXPECT_FALSE(halved.present(30, 15));
}

TEST(HalvedCandidates, APixelTakesItsCellsChoiceIfThatPhotographSeesIt) {
  TwoBesideEachOther two;
  for (int column = 69; column <= 71; ++column)  // something hides what falls on these from the first
    for (int row = 0; row < two.frames[0].camera.height; ++row) two.maps[0].inverse_z.at(row, column) = 60000;
  two.layer.at(51, 31) = kNoDisparity;
  const SourceCandidates whole(two.grid, two.layer, two.frames, two.maps, {});
  const HalvedCandidates halved(whole);
  SourceMap choice(halved.width(), halved.height(), 2);
  for (int y = 0; y < halved.height(); ++y)
    for (int x = 0; x < halved.width(); ++x) choice.set(x, y, 0);
  const SourceMap spread = halved.spread(choice, {});
  int taken = 0, other = 0;
  for (int y = 0; y < two.grid.height; ++y)
    for (int x = 0; x < two.grid.width; ++x) {
      if (!whole.present(x, y)) {
        EXPECT_EQ(spread.at(x, y), kNoSource);
        continue;
      }
      EXPECT_EQ(spread.at(x, y), whole.sees(0, x, y) ? 0 : whole.cheapest(x, y)) << x << ' ' << y;
      (spread.at(x, y) == 0 ? taken : other) += 1;
    }
  EXPECT_GT(taken, 100);
  EXPECT_GT(other, 100);
}

TEST(NeighbourViews, AreThePhotographsBesideAPixelsOwnThatSeeItsVoxel) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  std::vector<UprightFrame> frames;
  std::vector<VisibilityMap> maps;
  for (int i = 0; i < 6; ++i) {
    frames.push_back(upright_of(camera_at(0.01 * i), i));
    maps.push_back(map_of(frames.back(), i == 2 ? 60000 : 0));  // something hides all from the third
  }
  frames.push_back(upright_of(camera_at(2.5), 6));  // looks elsewhere
  maps.push_back(map_of(frames.back(), 0));
  SourceMap source(grid.width, grid.height, 7);
  source.set(50, 30, 1), source.set(51, 30, 5), source.set(52, 30, 4);
  const Plane<uint8_t> neighbours = SourceCandidates(grid, layer, frames, maps, {}).neighbours(source, {});
  EXPECT_EQ(neighbours.at(50, 30), 1 << neighbour_bit(-1) | 1 << neighbour_bit(2) | 1 << neighbour_bit(3));
  EXPECT_EQ(neighbours.at(51, 30), 1 << neighbour_bit(-1) | 1 << neighbour_bit(-2));
  EXPECT_EQ(neighbours.at(52, 30), 1 << neighbour_bit(-3) | 1 << neighbour_bit(-1) | 1 << neighbour_bit(1));
  EXPECT_EQ(neighbours.at(53, 30), 0);
}

constexpr uint8_t kAllNeighbours = (1 << kNeighbourViews) - 1;

// Photographs of a far wall, taken one after another.
struct Wall {
  PanoramaGrid grid = simple_grid(0.5);
  std::vector<RgbImage> photos;
  std::vector<Camera> cameras;
  SourceMap source{Plane<uint8_t>(grid.width, grid.height, 3)};
  Plane<uint8_t> neighbours{grid.width, grid.height, kAllNeighbours};

  explicit Wall(const std::vector<int>& levels) {
    for (const int level : levels) {
      cameras.push_back(camera_at(0.01 * static_cast<double>(cameras.size())));
      photos.emplace_back(140, 80, Rgb{static_cast<uint8_t>(level), 50, 60});
    }
  }

  // Something that one photograph alone shows at pixel (x, 30) and a little around it.
  void pass(int photo, int x, uint8_t level) {
    const auto i = static_cast<size_t>(photo);
    const Eigen::Vector3d direction = grid.direction(grid.theta(x + 0.5), grid.v(30.5));
    const Eigen::Vector2d middle =
        project(cameras[i].intrinsics, cameras[i].pose.world_from_camera.transpose() * direction);
    for (int v = -4; v <= 4; ++v)
      for (int u = -4; u <= 4; ++u)
        photos[i].at(static_cast<int>(middle.x()) + u, static_cast<int>(middle.y()) + v).r = level;
  }

  // The right half of the panorama from another photograph.
  void right_from(int photo) {
    for (int y = 0; y < grid.height; ++y)
      for (int x = 64; x < grid.width; ++x) source.set(x, y, photo);
  }

  void left_seen_by(int these) {
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < 64; ++x) neighbours.at(x, y) = static_cast<uint8_t>(these);
  }

  RgbImage panorama(bool even = false) const {
    const DisparityMap layer(grid.width, grid.height, 0);
    RgbImage colour(grid.width, grid.height);
    std::vector<int> frame_of_camera(photos.size());
    std::iota(frame_of_camera.begin(), frame_of_camera.end(), 0);
    const std::vector<Gain> gains(photos.size(), {1, 1, 1});
    ColourOptions options;
    options.level_seams = even;
    blend_colours(grid, {FramesInMemory(photos), cameras, frame_of_camera, gains},
                  {{&layer, &source, &colour, &neighbours}}, options, {});
    return colour;
  }
};

TEST(FetchColours, WhatOnePhotographAloneShowsIsNotKept) {
  for (const int neighbours : {int{kAllNeighbours}, 1 << neighbour_bit(-3) | 1 << neighbour_bit(3)}) {
    Wall wall({100, 103, 112, 127, 148, 175, 208});
    wall.pass(3, 53, 250);
    wall.left_seen_by(neighbours);
    const RgbImage panorama = wall.panorama();
    EXPECT_EQ(panorama.at(53, 30), (Rgb{127, 50, 60}));
    EXPECT_EQ(panorama.at(20, 30), (Rgb{127, 50, 60}));  // as bright as in its own photograph
  }
}

TEST(FetchColours, PhotographsBeyondAByteAreToldApart) {
  std::vector<int> levels(300, 100);
  levels[299] = 180;
  levels[299 - 256] = 20;
  for (const bool even : {false, true}) {
    Wall wall(levels);
    wall.source = SourceMap(wall.grid.width, wall.grid.height, 300);
    for (int y = 0; y < wall.grid.height; ++y)
      for (int x = 0; x < 64; ++x) wall.source.set(x, y, 299);
    wall.right_from(299 - 256);
    std::fill(wall.neighbours.samples.begin(), wall.neighbours.samples.end(), uint8_t{0});
    const RgbImage panorama = wall.panorama(even);
    EXPECT_EQ(panorama.at(5, 30).r, 180);
    EXPECT_EQ(panorama.at(wall.grid.width - 5, 30).r, 20);
  }
}

TEST(FetchColours, WhereFewerThanThreeSeeIsThePhotographsOwn) {
  Wall wall({100, 100, 100, 100, 100, 100, 100});
  wall.pass(3, 53, 250);
  for (const int neighbours : {0, 1 << neighbour_bit(1)}) {
    wall.left_seen_by(neighbours);
    EXPECT_EQ(wall.panorama().at(53, 30).r, 250);
  }
}

TEST(FetchColours, EachPhotographIsComparedWithThoseBesideItself) {
  Wall wall({63, 104, 122, 127, 128, 132, 150});
  wall.right_from(4);
  wall.pass(4, 66, 250);
  const RgbImage panorama = wall.panorama();
  EXPECT_EQ(panorama.at(20, 30).r, 127);
  EXPECT_EQ(panorama.at(66, 30).r, 128);
}

TEST(FetchColours, BrightnessDiffersFromPlaceToPlace) {
  Wall wall({120, 120, 120, 100, 120, 120, 120});
  for (int i = 0; i < 7; ++i)
    for (int y = 0; y < 80; ++y)
      for (int x = 70; x < 140; ++x) wall.photos[static_cast<size_t>(i)].at(x, y).r = i == 3 ? 100 : 80;
  wall.pass(3, 20, 250);
  wall.pass(3, 96, 250);
  const RgbImage panorama = wall.panorama();
  for (const int x : {8, 20, 96}) EXPECT_NEAR(panorama.at(x, 30).r, 100, 1) << x;
}

// Where two photographs meet, what one of them shows alone in the other's place moves no seam.
TEST(EvenSeams, SeeWhatPhotographsAgreeOn) {
  Wall wall({100, 100, 100, 100, 116, 116, 116});
  wall.right_from(4);
  wall.left_seen_by(1 << neighbour_bit(1) | 1 << neighbour_bit(2));  // three with their own
  const RgbImage clean = wall.panorama(true);
  EXPECT_LE(std::abs(clean.at(64, 30).r - clean.at(63, 30).r), 3);
  wall.pass(4, 60, 250);  // beyond the border, and on it
  EXPECT_EQ(wall.panorama(true).samples, clean.samples);
}

// Two photographs of one grey wall, the second brighter, meet at column `border` of the panorama.
RgbImage two_exposures(bool even, int border) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  SourceMap source(Plane<uint8_t>(grid.width, grid.height, 0));
  for (int y = 0; y < grid.height; ++y)
    for (int x = border; x < grid.width; ++x) source.set(x, y, 1);
  RgbImage colour(grid.width, grid.height);
  const FramesInMemory frames({RgbImage(140, 80, {100, 100, 100}), RgbImage(140, 80, {116, 100, 100})});
  const std::vector<Camera> cameras = {camera_at(0.02), camera_at(-0.02)};
  ColourOptions options;
  options.level_seams = even;
  blend_colours(grid, {frames, cameras, {0, 1}, {{1, 1, 1}, {1, 1, 1}}}, {{&layer, &source, &colour}}, options, {});
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
}  // namespace ldp::colour
