#include "core/layers/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stop_token>

#include "core/layers/neighbours.h"
#include "tests/unit/square_before_sky.h"

namespace ldp {
namespace {

using namespace test;

int count(const Plane<uint8_t>& want, Want wanted) {
  return static_cast<int>(std::count(want.samples.begin(), want.samples.end(), wanted));
}

TEST(ParallaxSteps, AreNeverMoreThanThereAre) {
  PanoramaGrid grid = simple_grid(0.5);
  const double usual = layers::parallax_steps(grid, 1);
  EXPECT_GT(usual, 0);
  EXPECT_DOUBLE_EQ(layers::parallax_steps(grid, 2), 2 * usual);
  grid.w_far = 0, grid.w_near = 1e-9;  // cameras at one place: nothing shifts
  EXPECT_EQ(layers::parallax_steps(grid, 1), kDisparitySteps);
}

TEST(Visibility, AWallIsSeenAtItsInverseDepth) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap wall(grid.width, grid.height, kNearSteps);
  const auto maps = visibility(grid, {&wall}, {upright_of(camera_at(0), 0)}, {}, {});
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_NEAR(maps[0].inverse_z.at(40, 70) * maps[0].scale, 0.5, 0.002);
}

TEST(Visibility, OfTwoLayersTheNearerShows) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap near(grid.width, grid.height, kNearSteps), far(grid.width, grid.height, kNearSteps / 2);
  const std::vector<UprightFrame> frames = {upright_of(camera_at(0), 0)};
  const auto one = visibility(grid, {&near}, frames, {}, {}), both = visibility(grid, {&far, &near}, frames, {}, {});
  for (int column = 50; column < 90; ++column)
    for (int row = 20; row < 60; ++row) ASSERT_EQ(one[0].inverse_z.at(row, column), both[0].inverse_z.at(row, column));
}

TEST(Visibility, ASlantedSurfaceHasNoCracks) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap slope(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) slope.at(x, y) = static_cast<uint16_t>(1500 + 8 * x);
  const auto maps = visibility(grid, {&slope}, {upright_of(camera_at(0.2), 0)}, {}, {});
  for (int column = 50; column < 80; ++column)
    for (int row = 30; row < 50; ++row) ASSERT_NE(maps[0].inverse_z.at(row, column), 0) << column << ", " << row;
}

TEST(Visibility, IsTheSameAtAnyThreadCount) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map = square_before_the_sky(grid);
  Job four;
  four.threads = 4;
  const auto one = visibility(grid, {&map}, three_cameras(), {}, {}),
             many = visibility(grid, {&map}, three_cameras(), {}, four);
  for (size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].inverse_z, many[i].inverse_z);
  EXPECT_EQ(wanted_behind(grid, map, {three_cameras(), one}, {}, {}),
            wanted_behind(grid, map, {three_cameras(), one}, {}, four));
}

TEST(Visibility, StopsWhenAsked) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map(grid.width, grid.height, 0);
  std::stop_source source;
  source.request_stop();
  Job job;
  job.stop = source.get_token();
  EXPECT_THROW(visibility(grid, {&map}, three_cameras(), {}, job), Cancelled);
}

TEST(FarthestAround, TakesTheFarthestWithinReachAndKeepsBroadSurfaces) {
  DisparityMap map(30, 20, 100);
  for (int y = 5; y < 15; ++y)
    for (int x = 10; x < 20; ++x) map.at(x, y) = 3000;
  map.at(2, 2) = 3500;
  PanoramaGrid grid = simple_grid(0.5);
  grid.width = 30, grid.height = 20;
  const DisparityMap sure = farthest_around(grid, map, 3);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const bool inside = x >= 13 && x < 17 && y >= 8 && y < 12;
      ASSERT_EQ(sure.at(x, y), inside ? 3000 : 100) << x << ", " << y;
    }
}

TEST(FarthestAround, TheSeamOfAClosedPanoramaIsNoEnd) {
  PanoramaGrid grid = simple_grid(0.5);
  DisparityMap map(grid.width, grid.height, 3000);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      if ((x * 31 + y * 17) % 23 == 0) map.at(x, y) = static_cast<uint16_t>(100 + x);
  const DisparityMap open = farthest_around(grid, map, 4);
  grid.wraps = true;
  const DisparityMap closed = farthest_around(grid, map, 4);
  EXPECT_NE(closed, open);
  for (const int columns : {1, 7, 50})
    EXPECT_EQ(farthest_around(grid, rotated(map, columns), 4), rotated(closed, columns));
  const DisparityMap all_round = farthest_around(grid, map, 1000);
  EXPECT_EQ(all_round,
            DisparityMap(grid.width, grid.height, *std::min_element(map.samples.begin(), map.samples.end())));
}

TEST(NearestAround, IsTheNearestOfASquareAndNeverWhatIsAbsent) {
  PanoramaGrid grid = simple_grid(0.5);
  grid.width = 40, grid.height = 30;
  DisparityMap map(grid.width, grid.height);
  for (size_t i = 0; i < map.samples.size(); ++i)
    map.samples[i] = i % 7 == 3 ? kNoDisparity : static_cast<uint16_t>(i * 7919 % 3000);
  for (int y = 10; y < 20; ++y)
    for (int x = 10; x < 20; ++x) map.at(x, y) = kNoDisparity;
  for (const bool wraps : {false, true})
    for (const int reach : {0, 1, 3, 4, 100}) {
      grid.wraps = wraps;
      const DisparityMap nearest = nearest_around(grid, map, reach), farthest = farthest_around(grid, map, reach);
      for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) {
          int most = -1, least = kNoDisparity;
          for (int ny = std::max(0, y - reach); ny <= std::min(grid.height - 1, y + reach); ++ny)
            for (int nx = x - std::min(reach, 40); nx <= x + std::min(reach, 40); ++nx) {
              if (!wraps && (nx < 0 || nx >= grid.width)) continue;
              const int d = map.at((nx + grid.width) % grid.width, ny);
              if (d != kNoDisparity) most = std::max(most, d), least = std::min(least, d);
            }
          ASSERT_EQ(nearest.at(x, y), most < 0 ? kNoDisparity : most) << x << ", " << y << ", " << reach;
          ASSERT_EQ(farthest.at(x, y), least) << x << ", " << y << ", " << reach;
        }
    }
}

TEST(Shifted, OffersWhatLiesBesideAndRoundTheSeamButNothingBeyondAnEdge) {
  PanoramaGrid grid = simple_grid(0.5);
  DisparityMap map(grid.width, grid.height, 100);
  map.at(0, 5) = 3000;
  map.at(7, grid.height - 1) = 2000;
  EXPECT_EQ(shifted(grid, map, -3, 0).at(3, 5), 3000);
  EXPECT_EQ(shifted(grid, map, 0, 4).at(0, 1), 3000);
  EXPECT_EQ(shifted(grid, map, 0, 4).at(7, grid.height - 2), 2000);
  EXPECT_EQ(shifted(grid, map, 2, 0).at(grid.width - 2, 5), 100);
  EXPECT_EQ(shifted(grid, map, -2, 0).at(1, 5), 3000);
  grid.wraps = true;
  EXPECT_EQ(shifted(grid, map, 2, 0).at(grid.width - 2, 5), 3000);
  EXPECT_EQ(shifted(grid, map, -2, 0).at(1, 5), 100);
}

TEST(WantedBehind, NothingBehindOneSurface) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap wall(grid.width, grid.height, kNearSteps / 2);
  const auto maps = visibility(grid, {&wall}, three_cameras(), {}, {});
  const auto want = wanted_behind(grid, wall, {three_cameras(), maps}, {}, {});
  for (int y = 15; y < 45; ++y)
    for (int x = 30; x < 70; ++x) ASSERT_EQ(want.at(x, y), kUnwanted) << x << ", " << y;
}

TEST(WantedBehind, OnlyBehindTheSquareAndHeldByTheSkyBesideIt) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map = square_before_the_sky(grid);
  const auto maps = visibility(grid, {&map}, three_cameras(), {}, {});
  const auto want = wanted_behind(grid, map, {three_cameras(), maps}, {}, {});
  EXPECT_GT(count(want, kWanted), 50);
  EXPECT_GT(count(want, kBoundary), 10);
  for (size_t i = 0; i < want.samples.size(); ++i) {
    const bool square = map.samples[i] == kNearSteps;
    ASSERT_NE(want.samples[i], square ? kBoundary : kWanted) << "pixel " << i;
  }
}

TEST(WantedBehind, OneCameraAtTheRaysSeesNothingBehind) {
  PanoramaGrid grid = simple_grid(0.5);
  grid.rays = Rays::central;
  grid.arc.radius = 1;
  Camera camera = camera_at(0);
  camera.pose.centre = {0, 0, 0};  // where all central rays start
  const std::vector<UprightFrame> frames = {upright_of(camera, 0)};
  const DisparityMap map = square_before_the_sky(grid);
  const auto want = wanted_behind(grid, map, {frames, visibility(grid, {&map}, frames, {}, {})}, {}, {});
  for (int y = 25; y < 35; ++y)
    for (int x = kFirst + 2; x < kEnd - 2; ++x) EXPECT_EQ(want.at(x, y), kUnwanted);
}

TEST(SmoothBehind, TakesOutSpecksOnBothSidesOfTheSeamAndStaysBehindTheSurface) {
  PanoramaGrid grid = simple_grid(0.5);
  grid.wraps = true;
  DisparityMap surface(grid.width, grid.height, 2000), layer(grid.width, grid.height, 300);
  layer.at(9, 5) = 1500;
  for (int y = 0; y < grid.height; ++y) layer.at(0, y) = layer.at(1, y) = 1500;  // two of seven columns, or of four
  layer.at(20, 5) = kNoDisparity;
  surface.at(30, 5) = 305;  // the median lies too close behind it
  layer.at(30, 5) = 100;
  for (int x = 40; x < 60; ++x)
    for (int y = 0; y < grid.height; ++y) layer.at(x, y) = 900;  // another surface
  smooth_behind(grid, surface, 10, 3, {}, layer);
  for (const int x : {0, 1, 9, 39, 60}) EXPECT_EQ(layer.at(x, 5), 300) << x;
  EXPECT_EQ(layer.at(20, 5), kNoDisparity);
  EXPECT_EQ(layer.at(30, 5), 100);
  for (const int x : {40, 59}) EXPECT_EQ(layer.at(x, 0), 900) << x;
}

TEST(DropUnseen, KeepsWhatFillsAHoleAndDropsTheRest) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map = square_before_the_sky(grid);
  const auto maps = visibility(grid, {&map}, three_cameras(), {}, {});
  DisparityMap sky(grid.width, grid.height, 0);
  const int kept = drop_unseen(grid, {three_cameras(), maps}, {}, sky);
  EXPECT_GT(kept, 0);
  EXPECT_EQ(sky.at(20, 30), kNoDisparity);  // sky beside the square is explained by the front layer
}

TEST(ContinueBackground, RunsInAStraightLineFromSideToSide) {
  Plane<uint8_t> want(6, 1, kWanted);
  want.at(0, 0) = want.at(5, 0) = kBoundary;
  DisparityMap surface(6, 1, 3000), layer(6, 1, kNoDisparity);
  surface.at(0, 0) = 100, surface.at(5, 0) = 200;
  continue_background(want, surface, 10, layer);
  EXPECT_EQ(layer.at(1, 0), 120);
  EXPECT_EQ(layer.at(4, 0), 180);
  EXPECT_EQ(layer.at(0, 0), kNoDisparity);
}

TEST(ContinueBackground, LeavesDepthsThatDisagreeByMoreThanALabel) {
  Plane<uint8_t> want(3, 1, kWanted);
  want.at(0, 0) = kBoundary;
  DisparityMap surface(3, 1, 3000), layer(3, 1, 1000);
  surface.at(0, 0) = 100;
  continue_background(want, surface, 10, layer);
  EXPECT_EQ(layer.at(1, 0), 1000);
}

class FlatCosts final : public CostSource {
 public:
  int width() const override { return 8; }
  int height() const override { return 4; }
  int labels() const override { return 16; }
  bool wraps() const override { return true; }
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override {
    const auto samples = static_cast<size_t>(window.width * window.height * 16);
    std::fill(cost, cost + samples, uint8_t{7});
    std::fill(median, median + samples, uint8_t{9});
  }
};

TEST(BoundaryCosts, HoldTheBackgroundAndLeaveTheRest) {
  const FlatCosts flat;
  Plane<uint8_t> want(8, 4, kWanted);
  want.at(1, 2) = kBoundary;
  const DisparityMap surface(8, 4, 3 * kLabelSteps), unknown(8, 4, kNoDisparity);
  const BoundaryCosts costs(flat, want, surface, unknown);
  std::vector<uint8_t> cost(3 * 4 * 16), median(cost.size());
  costs.read({7, 0, 3, 4}, cost.data(), median.data());  // columns 7, 0 and 1
  const uint8_t* held = cost.data() + (2 * 4 + 2) * 16;
  for (int l = 0; l < 16; ++l) EXPECT_EQ(held[l], l == 3 ? 0 : 255);
  EXPECT_EQ(std::count(cost.begin(), cost.end(), 7), 11 * 16);
}

TEST(BoundaryCosts, FartherThanIsLikelyIsDearerWhereWanted) {
  const FlatCosts flat;
  Plane<uint8_t> want(8, 4, kWanted);
  want.at(1, 2) = kUnwanted;
  const DisparityMap surface(8, 4, 12 * kLabelSteps);
  DisparityMap likely(8, 4, 0);
  likely.at(0, 2) = likely.at(1, 2) = 5 * kLabelSteps;
  const BoundaryCosts costs(flat, want, surface, likely);
  std::vector<uint8_t> cost(3 * 4 * 16), median(cost.size());
  costs.read({7, 0, 3, 4}, cost.data(), median.data());  // columns 7, 0 and 1
  const uint8_t* limited = cost.data() + (1 * 4 + 2) * 16;
  for (int l = 0; l < 16; ++l) EXPECT_EQ(limited[l], l < 5 ? 7 + 32 : 7) << l;
  EXPECT_EQ(std::count(cost.begin(), cost.end(), 7), 12 * 16 - 5);
}

TEST(LikelyBehind, IsTheFarthestOfTheFrontWithinReachAndALittleMore) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap front(grid.width, grid.height, 3000);
  front.at(40, 20) = 900;
  const DisparityMap likely = likely_behind(grid, front, 6);
  const int far = likely.at(46, 26), near = likely.at(47, 26);
  EXPECT_LT(far, 900);
  EXPECT_GT(far, 0);
  EXPECT_EQ(near - far, 3000 - 900);
  EXPECT_EQ(likely_behind(grid, DisparityMap(grid.width, grid.height, 1), 6).at(9, 9), 0);
  EXPECT_EQ(likely_behind(grid, DisparityMap(grid.width, grid.height, kNoDisparity), 6).at(9, 9), kNoDisparity);
}

DisparityMap row(const std::vector<uint16_t>& samples) {
  DisparityMap map(static_cast<int>(samples.size()), 1);
  std::copy(samples.begin(), samples.end(), map.samples.begin());
  return map;
}

TEST(DropSpecks, RemovesPartsOfFewerPixelsAndNoOthers) {
  DisparityMap layer(8, 4, kNoDisparity);
  for (int x = 0; x < 3; ++x) layer.at(x, 0) = 100;  // three in a row
  layer.at(4, 1) = layer.at(5, 2) = 200;             // two that touch at a corner
  layer.at(7, 3) = 300;
  layer.at(0, 3) = layer.at(1, 3) = 400;  // three with the one before, round the seam
  DisparityMap open = layer, closed = layer;
  drop_small_components(3, false, open);
  drop_small_components(3, true, closed);
  DisparityMap expected(8, 4, kNoDisparity);
  for (int x = 0; x < 3; ++x) expected.at(x, 0) = 100;
  EXPECT_EQ(open.samples, expected.samples);
  expected.at(7, 3) = 300;
  expected.at(0, 3) = expected.at(1, 3) = 400;
  EXPECT_EQ(closed.samples, expected.samples);
}

TEST(DropSpecks, TellsPartsApartByWhatMayDifferFromPixelToPixel) {
  DisparityMap layer = row({10, 11, 12, 20, 21, 5});
  drop_small_components(3, false, layer, 1);
  EXPECT_EQ(layer, row({10, 11, 12, kNoDisparity, kNoDisparity, kNoDisparity}));
}

// What every pixel's labels cost, set by hand.
class GivenCosts final : public CostSource {
 public:
  GivenCosts(int width, int height, bool wraps) : width_(width), height_(height), wraps_(wraps) {
    cost_.assign(static_cast<size_t>(width * height * labels()), 50);
  }
  uint8_t& at(int x, int y, int label) { return cost_[static_cast<size_t>((x * height_ + y) * labels() + label)]; }

  int width() const override { return width_; }
  int height() const override { return height_; }
  int labels() const override { return 16; }
  bool wraps() const override { return wraps_; }
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override {
    for (int i = 0; i < window.width; ++i) {
      const int first = ((window.x + i) % width_ * height_ + window.y) * labels(), count = window.height * labels();
      cost = std::copy_n(cost_.begin() + first, count, cost);
      median = std::fill_n(median, count, uint8_t{9});
    }
  }

 private:
  int width_, height_;
  bool wraps_;
  std::vector<uint8_t> cost_;
};

void read_all(const CheapestLabels& costs, const Window& window) {
  std::vector<uint8_t> cost(static_cast<size_t>(window.width * window.height * costs.labels())), median(cost.size());
  costs.read(window, cost.data(), median.data());
}

TEST(CheapestLabels, AreRememberedOfWhatIsReadAndCostsAreUnchanged) {
  GivenCosts given(10, 6, true);
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 6; ++y) given.at(x, y, x + y) = 7;
  const CheapestLabels costs(given);
  const Window window{8, 1, 4, 3};  // across the seam
  std::vector<uint8_t> cost(static_cast<size_t>(window.width * window.height * 16)), median(cost), own(cost);
  costs.read(window, cost.data(), median.data());
  given.read(window, own.data(), median.data());
  EXPECT_EQ(cost, own);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 10; ++x) {
      const bool read = (x >= 8 || x < 2) && y >= 1 && y < 4;
      EXPECT_EQ(costs.cheapest().at(x, y), read ? x + y : CheapestLabels::kUnread) << x << ", " << y;
    }
}

TEST(CheapestLabels, ClearlyNearerOnesAreKeptInLargePartsAlone) {
  GivenCosts given(7, 3, false);
  for (int y = 0; y < 3; ++y) {
    given.at(1, y, 5 + y) = 20;                      // a post
    given.at(3, y, 9) = 20, given.at(3, y, 2) = 24;  // one that is hardly better than the label chosen
    given.at(5, y, 0) = 20;                          // farther
  }
  given.at(6, 0, 3) = given.at(6, 1, 8) = given.at(6, 2, 12) = 20;  // apart from each other
  const CheapestLabels costs(given);
  read_all(costs, {0, 0, 7, 3});
  const Plane<uint8_t> chosen(7, 3, 2);
  Plane<uint8_t> expected(7, 3, 0);
  for (int y = 0; y < 3; ++y) expected.at(1, y) = 1;
  EXPECT_EQ(costs.clearly_nearer(chosen, 3), expected);
  EXPECT_EQ(costs.clearly_nearer(chosen, 4), Plane<uint8_t>(7, 3, 0));
  const CheapestLabels unread(given);
  EXPECT_EQ(unread.clearly_nearer(chosen, 1), Plane<uint8_t>(7, 3, 0));
}

TEST(AbsorbSpecks, GivesSmallPartsTheMedianBesideThemAndLeavesLargerOnesAndSlopes) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap layer(grid.width, grid.height, 100);
  for (int y = 40; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) layer.at(x, y) = static_cast<uint16_t>(2000 + x);  // a slope
  for (int x = 60; x < 66; ++x) layer.at(x, 20) = 3000;                                     // large enough
  layer.at(0, 30) = kNoDisparity;
  const DisparityMap clean = layer;
  for (int x = 10; x < 15; ++x) layer.at(x, 10) = 3000;
  layer.at(grid.width - 1, 0) = 3000;
  absorb_specks(grid, 6, layer);
  EXPECT_EQ(layer, clean);
  DisparityMap all(grid.width, 1, 7);
  absorb_specks(grid, 1000, all);
  EXPECT_EQ(all, DisparityMap(grid.width, 1, 7));
}

TEST(FinerColumns, LieOnTheLineBetweenColumnsOfOneSurfaceAndOnTheirOwnBesideAnother) {
  const auto far = static_cast<uint16_t>(140 + kLabelSteps);  // another surface
  const DisparityMap layer = row({100, 140, far, kNoDisparity}), finer = with_finer_columns(layer, 2, false);
  EXPECT_EQ(finer, row({100, 110, 130, 140, far, far, kNoDisparity, kNoDisparity}));
  EXPECT_EQ(with_finer_columns(layer, 1, false), layer);
}

TEST(FinerColumns, GoOnAcrossTheSeam) {
  const DisparityMap layer = row({100, 140});
  EXPECT_EQ(with_finer_columns(layer, 2, true), row({110, 110, 130, 130}));
  EXPECT_EQ(with_finer_columns(layer, 2, false), row({100, 110, 130, 140}));
}

}  // namespace
}  // namespace ldp
