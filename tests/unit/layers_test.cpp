#include "core/layers/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stop_token>

#include "core/layers/neighbours.h"
#include "core/layers/painting/map_painter.h"
#include "core/layers/painting/photo_consistency.h"
#include "core/layers/proposal_fusion.h"
#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

using test::camera_at, test::simple_grid, test::upright_of;

constexpr uint16_t kNearSteps = kDisparitySteps;  // w = 0.5 in these tests: 2 from the circle
constexpr int kFirst = 45, kEnd = 55;             // columns of the near square

// A far wall at infinity, in front of it a square.
DisparityMap square_before_the_sky(const PanoramaGrid& grid) {
  DisparityMap map(grid.width, grid.height, 0);
  for (int y = 20; y < 40; ++y)
    for (int x = kFirst; x < kEnd; ++x) map.at(x, y) = kNearSteps;
  return map;
}

std::vector<UprightFrame> three_cameras() {
  return {upright_of(camera_at(0.25), 0), upright_of(camera_at(0), 1), upright_of(camera_at(-0.25), 2)};
}

std::vector<VisibilityMap> visibility(const PanoramaGrid& grid, const std::vector<const DisparityMap*>& layers,
                                      const std::vector<UprightFrame>& frames, const LayersOptions& options,
                                      const Job& job) {
  std::vector<VisibilityMap> maps;
  for (const DisparityMap* layer : layers) add_layer(grid, *layer, frames, options, job, maps);
  return maps;
}

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

TEST(WithoutSilhouettes, TakesTheFarthestWithinReachAndKeepsBroadSurfaces) {
  DisparityMap map(30, 20, 100);
  for (int y = 5; y < 15; ++y)
    for (int x = 10; x < 20; ++x) map.at(x, y) = 3000;
  map.at(2, 2) = 3500;
  const DisparityMap sure = without_silhouettes(map, 3);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const bool inside = x >= 13 && x < 17 && y >= 8 && y < 12;
      ASSERT_EQ(sure.at(x, y), inside ? 3000 : 100) << x << ", " << y;
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

TEST(MoveIntoSight, GivesEveryWantedPixelADisparityBehindTheFrontThatSomeCameraSees) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap map = square_before_the_sky(grid);
  const auto frames = three_cameras();
  const auto maps = visibility(grid, {&map}, frames, {}, {});
  const auto want = wanted_behind(grid, map, {frames, maps}, {}, {});
  const int gap = gap_steps(grid, {});
  DisparityMap layer(grid.width, grid.height, kNoDisparity);
  for (int x = 0; x < 50; ++x) layer.at(x, 30) = kNearSteps;  // not behind the square
  const DisparityMap before = layer;
  move_to_visible(grid, map, gap, {frames, maps}, want, {}, layer);
  for (size_t i = 0; i < want.samples.size(); ++i) {
    if (want.samples[i] == kWanted)
      ASSERT_LE(layer.samples[i] + gap, map.samples[i]);
    else
      ASSERT_EQ(layer.samples[i], before.samples[i]);
  }
  EXPECT_GE(drop_unseen(grid, {frames, maps}, {}, layer), count(want, kWanted) * 9 / 10);
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
  DisparityMap surface(8, 4, 3 * kLabelSteps);
  const BoundaryCosts costs(flat, want, surface);
  std::vector<uint8_t> cost(3 * 4 * 16), median(cost.size());
  costs.read({7, 0, 3, 4}, cost.data(), median.data());  // columns 7, 0 and 1
  const uint8_t* held = cost.data() + (2 * 4 + 2) * 16;
  for (int l = 0; l < 16; ++l) EXPECT_EQ(held[l], l == 3 ? 0 : 255);
  EXPECT_EQ(std::count(cost.begin(), cost.end(), 7), 11 * 16);
}

}  // namespace
enum class Plain { nothing, square, all };

// What cameras see of square_before_the_sky: two patterns, or one or none.
std::vector<UprightFrame> photographs_of_the_square(const PanoramaGrid& grid, Plain plain) {
  const DisparityMap truth = square_before_the_sky(grid);
  const auto column = [&](double theta) { return (grid.theta_left - theta) / grid.theta_pitch; };
  const auto row = [&](double v) { return (grid.v_top - v) / grid.v_pitch; };
  const auto grey = [&](const Eigen::Vector3d& centre, const Eigen::Vector3d& direction) {
    const double depth = 1 / grid.w_near, radius = grid.arc.radius + depth;
    const double a = direction.x() * direction.x() + direction.y() * direction.y();
    const double b = direction.x() * centre.x() + direction.y() * centre.y();
    const double c = centre.x() * centre.x() + centre.y() * centre.y() - radius * radius;
    const Eigen::Vector3d p = centre + direction * ((-b + std::sqrt(b * b - a * c)) / a);
    const double x = column(std::atan2(p.y(), p.x())), y = row(p.z() / depth);
    if (truth.contains(static_cast<int>(x), static_cast<int>(y)) &&
        truth.at(static_cast<int>(x), static_cast<int>(y)) == kNearSteps)
      return plain == Plain::square ? 120 : 120 + 50 * std::sin(1.1 * x) + 50 * std::cos(0.9 * y);
    const double far_x = column(std::atan2(direction.y(), direction.x())), far_y = row(direction.z() / std::sqrt(a));
    return 130 + 60 * std::sin(0.8 * far_x + 0.5 * far_y) + 50 * std::cos(0.6 * far_y - 1.3 * far_x);
  };
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 5; ++i) {
    const Camera camera = camera_at(0.3 - 0.15 * i);
    frames.push_back(upright_of(camera, i));
    for (int y = 0; y < camera.intrinsics.height; ++y)
      for (int x = 0; x < camera.intrinsics.width; ++x) {
        const Eigen::Vector3d ray = camera.pose.world_from_camera * unproject(camera.intrinsics, {x + 0.5, y + 0.5});
        frames.back().columns.at(y, x) =
            plain == Plain::all ? uint8_t{90} : static_cast<uint8_t>(std::lround(grey(camera.pose.centre, ray)));
      }
  }
  return frames;
}

DisparityMap fattened_square(const PanoramaGrid& grid, int by_px) {
  DisparityMap map = square_before_the_sky(grid);
  for (int y = 20 - by_px; y < 40 + by_px; ++y)
    for (int x = kFirst - by_px; x < kEnd + by_px; ++x) map.at(x, y) = kNearSteps;
  return map;
}

int differing(const DisparityMap& a, const DisparityMap& b) {
  int count = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) count += a.samples[i] != b.samples[i];
  return count;
}

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

// What stands in the right half of the panorama alone.
DisparityMap halves(const DisparityMap& left, const DisparityMap& right) {
  DisparityMap map = left;
  for (int y = 0; y < map.height; ++y)
    for (int x = map.width / 2; x < map.width; ++x) map.at(x, y) = right.at(x, y);
  return map;
}

DisparityMap fused(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, DisparityMap layer,
                   const DisparityMap& proposal, const Job& job = {}, int reach_px = 5, int columns_apart = 2) {
  ProposalFusion(grid, frames, columns_apart).fuse(proposal, reach_px, job, layer);
  return layer;
}

// Nothing where the square is, another one beside it, and one that is too wide.
std::vector<DisparityMap> wrong_maps(const PanoramaGrid& grid) {
  DisparityMap beside = square_before_the_sky(grid);
  for (int y = 22; y < 34; ++y)
    for (int x = 25; x < 37; ++x) beside.at(x, y) = kNearSteps;
  return {DisparityMap(grid.width, grid.height, 0), beside, fattened_square(grid, 4)};
}

TEST(FuseProposal, TakesWhatThePhotographsAgreeOnAndLeavesWhatTheyContradict) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::nothing);
  const DisparityMap truth = square_before_the_sky(grid);
  for (const int columns_apart : {1, 2})
    for (const DisparityMap& wrong : wrong_maps(grid)) {
      EXPECT_EQ(fused(grid, frames, wrong, truth, {}, 5, columns_apart), truth);
      EXPECT_EQ(fused(grid, frames, truth, wrong, {}, 5, columns_apart), truth);
    }
}

TEST(FuseProposal, DecidesPlaceByPlace) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::nothing);
  const DisparityMap truth = square_before_the_sky(grid), wrong = DisparityMap(grid.width, grid.height, 0);
  EXPECT_EQ(fused(grid, frames, halves(truth, wrong), halves(wrong, truth)), truth);
}

// Of the surfaces that are there; asked of what hides a place, too, cameras would contradict 306 pixels.
TEST(PhotoConsistency, NoCameraContradictsTheTruth) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::nothing);
  const DisparityMap truth = square_before_the_sky(grid);
  const auto maps = visibility(grid, {&truth}, frames, {}, {});
  std::vector<const VisibilityMap*> of_cameras;
  for (const VisibilityMap& map : maps) of_cameras.push_back(&map);
  const layers::PhotoConsistency photos(grid, frames, 1);
  int seen = 0, contradicted = 0;
  layers::PhotoConsistency::Pixels column;
  for (int y = 0; y < 80; ++y) column.rows.push_back(y);
  std::vector<int> found;
  for (; column.x < 140; ++column.x) {
    photos.differences(2, column, of_cameras, found);
    for (int y = 0; y < 80; ++y) {
      if (maps[2].inverse_z.at(y, column.x) == 0) continue;
      ++seen;
      contradicted += found[static_cast<size_t>(y)] > 16 * 4;
    }
  }
  EXPECT_GT(seen, 4000);
  EXPECT_LT(contradicted, 60);
}

// Pictures of nothing but noise, another one in each camera.
std::vector<UprightFrame> noisy_photographs() {
  std::vector<UprightFrame> frames = three_cameras();
  uint32_t state = 1;
  for (UprightFrame& frame : frames)
    for (uint8_t& sample : frame.columns.samples) {
      state = state * 1664525 + 1013904223;
      sample = static_cast<uint8_t>(112 + (state >> 24));
    }
  return frames;
}

DisparityMap with_specks(DisparityMap map, uint16_t disparity) {
  for (int y = 1; y + 1 < map.height; ++y)
    for (int x = 1; x + 1 < map.width; ++x)
      if ((x * 7 + y * 5) % 4 == 0) map.at(x, y) = disparity;
  return map;
}

// Every proposal suits some noise better: what is rougher must suit it clearly, and what is smoother may be taken more
// easily where it is farther.
TEST(FuseProposal, OfNoiseTakesLittleThatIsRoughAndWhatIsSmoothWhereItIsFarther) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap far(grid.width, grid.height, 0), near(grid.width, grid.height, kNearSteps),
      far_specks = with_specks(near, 0), near_specks = with_specks(far, kNearSteps);
  const auto taken = [&](const DisparityMap& layer, const DisparityMap& proposal) {
    return differing(fused(grid, noisy_photographs(), layer, proposal, {}, 1), layer);
  };
  // Were roughness nothing: 391, 273, 443 and 418.
  EXPECT_LT(taken(far, near_specks), 320);
  EXPECT_LT(taken(near, far_specks), 210);
  EXPECT_LT(taken(far_specks, near), 500);
  EXPECT_GT(taken(near_specks, far), 500);
}

// Where no photograph tells anything, neither does smoothness.
TEST(FuseProposal, WhatNoTwoPhotographsSeeStays) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap square = square_before_the_sky(grid), flat(grid.width, grid.height, 0);
  const std::vector<UprightFrame> one = {upright_of(camera_at(0), 0)};
  EXPECT_EQ(fused(grid, one, square, flat), square);
  EXPECT_EQ(fused(grid, one, flat, square), flat);
}

TEST(MapPainter, EverySecondColumnIsTheOneOfTheWholeMap) {
  const PanoramaGrid grid = simple_grid(0.5);
  const layers::Brush brush(grid, square_before_the_sky(grid), {});
  const UprightFrame frame = upright_of(camera_at(-0.25), 0);
  const auto painted = [&](int columns_apart) {
    layers::PaintedView view;
    layers::empty_map(grid, frame.camera, {}, view.map, columns_apart);
    layers::assign(view.seen, frame.camera.height, layers::columns_of_map(frame.camera, columns_apart),
                   layers::kSeesNothing);
    layers::MapPainter painter(brush, frame.camera, view.map, &view.seen, columns_apart);
    for (int x = 0; x < grid.width; ++x) painter.paint(x);
    return view;
  };
  const layers::PaintedView whole = painted(1);
  for (const int apart : {2, 3}) {
    const layers::PaintedView some = painted(apart);
    ASSERT_EQ(some.seen.height, (frame.camera.width + apart - 1) / apart);
    for (int column = 0; column < some.seen.height; ++column)
      for (int row = 0; row < frame.camera.height; ++row) {
        ASSERT_EQ(some.seen.at(row, column), whole.seen.at(row, column * apart)) << column << ", " << row;
        ASSERT_EQ(some.map.inverse_z.at(row, column), whole.map.inverse_z.at(row, column * apart));
      }
  }
}

TEST(MapPainter, TellsThePixelThatIsSeenAndNotThoseBehindIt) {
  const PanoramaGrid grid = simple_grid(0.5);
  const layers::Brush brush(grid, square_before_the_sky(grid), {});
  const UprightFrame frame = upright_of(camera_at(-0.25), 0);
  layers::SeenPixels seen(frame.camera.height, frame.camera.width, layers::kSeesNothing);
  VisibilityMap map;
  layers::empty_map(grid, frame.camera, {}, map);
  layers::MapPainter painter(brush, frame.camera, map, &seen);
  for (int x = grid.width - 1; x >= 0; --x) painter.paint(x);
  int near = 0;
  for (int column = 0; column < frame.camera.width; ++column)
    for (int row = 0; row < frame.camera.height; ++row) {
      const bool square = map.inverse_z.row(column)[row] * map.scale > 0.2;
      const int x = static_cast<int>(seen.row(column)[row]) / grid.height;
      near += square;
      if (square) {
        ASSERT_TRUE(x >= kFirst && x < kEnd) << column << ", " << row;
      }
    }
  EXPECT_GT(near, 100);
}

DisparityMap without_columns(DisparityMap map, int begin, int end) {
  for (int y = 0; y < map.height; ++y)
    for (int x = begin; x < end; ++x) map.at(x, y) = 0;
  return map;
}

// Beside it the cameras to one side see more of the same square: they agree about the sky behind it by chance.
TEST(FuseProposal, AsksNoCameraThatSeesSomethingElseThere) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::square);
  const DisparityMap truth = square_before_the_sky(grid);
  for (const DisparityMap& eaten :
       {without_columns(truth, kFirst, kFirst + 2), without_columns(truth, kEnd - 2, kEnd)}) {
    EXPECT_EQ(fused(grid, frames, truth, eaten), truth);
    EXPECT_EQ(fused(grid, frames, eaten, truth), truth);
  }
}

TEST(FuseProposal, DecidesOnWhatIsNearerAndWhatIsFartherApart) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::nothing);
  const DisparityMap truth = square_before_the_sky(grid);
  const DisparityMap layer = without_columns(truth, kFirst, kFirst + 3),
                     proposal = without_columns(truth, kEnd - 5, kEnd);
  EXPECT_EQ(fused(grid, frames, layer, proposal, {}, 50), truth);
}

// A plain square at a wrong depth: photographs tell at its outline alone.
TEST(FuseProposal, TakesAlongWhatChangesAlikeWithinReach) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::square);
  const DisparityMap truth = square_before_the_sky(grid);
  DisparityMap wrong = truth;
  for (uint16_t& d : wrong.samples) d = static_cast<uint16_t>(d * 7 / 8);
  EXPECT_EQ(fused(grid, frames, wrong, truth, {}, 0).at((kFirst + kEnd) / 2, 28), wrong.at((kFirst + kEnd) / 2, 28));
  EXPECT_EQ(fused(grid, frames, wrong, truth, {}, 12), truth);
}

TEST(FuseProposal, LeavesWhatPhotographsCannotTell) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer = square_before_the_sky(grid);
  EXPECT_EQ(fused(grid, photographs_of_the_square(grid, Plain::all), layer, fattened_square(grid, 1)), layer);
  EXPECT_EQ(fused(grid, {photographs_of_the_square(grid, Plain::nothing)[2]}, layer, fattened_square(grid, 4)), layer);
}

TEST(FuseProposal, LeavesAbsentPixelsAndWhatIsOneSurface) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::nothing);
  const DisparityMap truth = square_before_the_sky(grid);
  DisparityMap absent = truth, finer = truth;
  absent.at(50, 30) = kNoDisparity;
  for (uint16_t& d : finer.samples) d = static_cast<uint16_t>(d == 0 ? 1 : d);
  EXPECT_EQ(fused(grid, frames, absent, truth), absent);
  EXPECT_EQ(fused(grid, frames, truth, absent), truth);
  EXPECT_EQ(fused(grid, frames, finer, truth), finer);
}

TEST(FuseProposal, IsTheSameAtAnyThreadCountAndInAnyOrderOfCamerasAndStopsWhenAsked) {
  const PanoramaGrid grid = simple_grid(0.5);
  auto frames = photographs_of_the_square(grid, Plain::nothing);
  const DisparityMap truth = square_before_the_sky(grid), wrong = wrong_maps(grid)[1];
  Job job;
  const DisparityMap one = fused(grid, frames, wrong, truth);
  job.threads = 4;
  EXPECT_EQ(fused(grid, frames, wrong, truth, job), one);
  std::reverse(frames.begin(), frames.end());
  EXPECT_EQ(fused(grid, frames, wrong, truth, job), one);
  std::stop_source source;
  source.request_stop();
  job.stop = source.get_token();
  EXPECT_THROW(fused(grid, frames, wrong, truth, job), Cancelled);
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

}  // namespace ldp
