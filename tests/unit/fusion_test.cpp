// Proposals fused into a layer where photographs agree more, and how that is measured.
#include "core/layers/proposal_fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stop_token>
#include <utility>

#include "core/layers/painting/map_painter.h"
#include "core/layers/painting/photo_consistency.h"
#include "tests/unit/square_before_sky.h"

namespace ldp {
namespace {

using namespace test;

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

// What camera 2 sees of a layer, and by how much the others contradict it [1/16 grey levels].
struct Contradicted {
  VisibilityMap seen;
  Plane<int> by;  // stored like the map
};

Contradicted contradicted(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames,
                          const DisparityMap& layer) {
  auto maps = visibility(grid, {&layer}, frames, {}, {});
  std::vector<const VisibilityMap*> of_cameras;
  for (const VisibilityMap& map : maps) of_cameras.push_back(&map);
  const layers::PhotoConsistency photos(grid, frames, 1);
  Plane<int> by(80, 140);
  layers::PhotoConsistency::Pixels column;
  for (int y = 0; y < by.width; ++y) column.rows.push_back(y);
  std::vector<int> found;
  for (; column.x < by.height; ++column.x) {
    photos.look(2, column);
    photos.differences(2, column, of_cameras, found);
    std::copy(found.begin(), found.end(), by.row(column.x));
  }
  return {std::move(maps[2]), std::move(by)};
}

// Of the surfaces that are there; asked of what hides a place, too, cameras would contradict 306 pixels.
TEST(PhotoConsistency, NoCameraContradictsTheTruth) {
  const PanoramaGrid grid = simple_grid(0.5);
  const Contradicted truth =
      contradicted(grid, photographs_of_the_square(grid, Plain::nothing), square_before_the_sky(grid));
  int seen = 0, many = 0;
  for (size_t i = 0; i < truth.by.samples.size(); ++i) {
    if (truth.seen.inverse_z.samples[i] == 0) continue;
    ++seen;
    many += truth.by.samples[i] > 16 * 4;
  }
  EXPECT_GT(seen, 4000);
  EXPECT_LT(many, 60);
}

TEST(PhotoConsistency, CamerasContradictASurfaceThatOverhangsByAPixel) {
  const PanoramaGrid grid = simple_grid(0.5);
  const auto frames = photographs_of_the_square(grid, Plain::nothing);
  const Contradicted truth = contradicted(grid, frames, square_before_the_sky(grid)),
                     wide = contradicted(grid, frames, fattened_square(grid, 1));
  int overhanging = 0, right = 0, sum = 0, sum_of_right = 0;
  for (size_t i = 0; i < truth.by.samples.size(); ++i) {
    const bool same = truth.seen.inverse_z.samples[i] == wide.seen.inverse_z.samples[i];
    (same ? right : overhanging) += 1;
    (same ? sum_of_right : sum) += wide.by.samples[i];
  }
  EXPECT_GT(overhanging, 50);
  EXPECT_GT(sum, 10 * 16 * overhanging);    // 16 grey levels a pixel; did a whole pixel around count, 3
  EXPECT_LT(sum_of_right, 4 * 16 * right);  // 2; were samples not taken between pixels, 8
}

// Pictures of nothing but noise of so many bits, another one in each camera.
std::vector<UprightFrame> noisy_photographs(int bits) {
  std::vector<UprightFrame> frames = three_cameras();
  uint32_t state = 1;
  for (UprightFrame& frame : frames)
    for (uint8_t& sample : frame.columns.samples) {
      state = state * 1664525 + 1013904223;
      sample = static_cast<uint8_t>(112 + (state >> (32 - bits)));
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
  const auto taken = [&](int bits, const DisparityMap& layer, const DisparityMap& proposal) {
    return differing(fused(grid, noisy_photographs(bits), layer, proposal, {}, 1), layer);
  };
  ASSERT_EQ(differing(far, near_specks), 1422);
  // A sensor's noise in the dark (9 grey levels, root mean square). Were roughness nothing: 306, 60 and, of the last,
  // 852; were what is smoother and nearer taken as easily: 1295 of the third.
  EXPECT_LT(taken(5, far, near_specks), 70);
  EXPECT_LT(taken(5, near, far_specks), 20);
  EXPECT_LT(taken(5, far_specks, near), 1200);
  EXPECT_GT(taken(5, near_specks, far), 1150);
  // All that levels can differ, where everything tells something. Likewise 549, 721 and 772; 827. Did no surface go on
  // where none covers: 850, 996, 102 and 456.
  EXPECT_LT(taken(8, far, near_specks), 400);
  EXPECT_LT(taken(8, near, far_specks), 500);
  EXPECT_LT(taken(8, far_specks, near), 600);
  EXPECT_GT(taken(8, near_specks, far), 850);
}

TEST(FuseProposal, OfAClosedPanoramaDoesNotDependOnWhereItsSeamLies) {
  constexpr int kMiddle = 320;
  const PanoramaGrid grid = closed_grid(kMiddle);
  const DisparityMap far(grid.width, grid.height, 0), near(grid.width, grid.height, kNearSteps);
  const std::pair<DisparityMap, DisparityMap> pairs[] = {{far, with_specks(far, kNearSteps)},
                                                         {near, with_specks(near, 0)},
                                                         {with_specks(near, 0), near},
                                                         {with_specks(far, kNearSteps), far}};
  for (const auto& [layer, proposal] : pairs)
    for (const int reach_px : {1, 5, 400}) {
      const DisparityMap whole = fused(grid, noisy_photographs(8), layer, proposal, {}, reach_px);
      for (const int seam : {0, 1, 25}) {
        const int columns = seam - kMiddle + grid.width;
        EXPECT_EQ(fused(closed_grid(seam), noisy_photographs(8), rotated(layer, columns), rotated(proposal, columns),
                        {}, reach_px),
                  rotated(whole, columns))
            << seam << ", " << reach_px;
      }
    }
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

TEST(MapPainter, TheFartherOfTwoSurfacesGoesOnBetweenThemAndNoneBeyondThem) {
  VisibilityMap map;
  map.inverse_z = Plane<uint16_t>(3, 8, layers::kUncovered);  // of three rows, column by column
  const std::vector<std::vector<uint16_t>> rows = {
      {0, 9, 0, 0, 4, 0, 5, 0}, {0, 0, 0, 0, 0, 0, 0, 0}, {7, 0, 7, 3, 0, 0, 0, 8}};
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 8; ++x) map.inverse_z.at(y, x) = rows[static_cast<size_t>(y)][static_cast<size_t>(x)];
  layers::continue_farther_surfaces(map);
  const std::vector<std::vector<uint16_t>> continued = {
      {0, 9, 4, 4, 4, 4, 5, 0}, {0, 0, 0, 0, 0, 0, 0, 0}, {7, 7, 7, 3, 3, 3, 3, 8}};
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 8; ++x)
      EXPECT_EQ(map.inverse_z.at(y, x), continued[static_cast<size_t>(y)][static_cast<size_t>(x)]) << x << ", " << y;
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

// A part of the square's size at another depth, with what is simpler: without it.
TEST(SimplifyLayer, DropsWhatPhotographsDoNotTellAndKeepsWhatTheyShow) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap square = square_before_the_sky(grid), sky(grid.width, grid.height, 0);
  const auto simplified = [&](const std::vector<UprightFrame>& frames) {
    DisparityMap layer = square;
    ProposalFusion(grid, frames, 2).simplify(sky, 2, {}, layer);
    return layer;
  };
  EXPECT_EQ(simplified(photographs_of_the_square(grid, Plain::nothing)), square);
  EXPECT_EQ(simplified(photographs_of_the_square(grid, Plain::all)), sky);
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

}  // namespace
}  // namespace ldp
