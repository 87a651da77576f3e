// The grid of a build within the memory allowed, and the coding of what was found on it.
#include "core/pipeline/grid_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/panorama/file/ldp_file.h"
#include "core/pipeline/code_layers.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/pipeline_tuning.h"
#include "core/pipeline/pose_evidence.h"
#include "core/pipeline/stopwatch.h"
#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// Nine cameras over one radian of a circle of radius 1, and points at depths of 2 to 20.
Poses simple_poses() {
  Poses poses;
  for (int i = 0; i < 9; ++i) {
    poses.cameras.push_back(test::camera_at(0.5 - 0.125 * i));
    poses.frame_of_camera.push_back(i);
  }
  for (int i = 0; i < 200; ++i) {
    const double theta = 0.5 - i / 200.0, depth = 3 + 18.0 * (i * 7 % 50) / 50;
    ScenePoint point;
    point.position = {depth * std::cos(theta), depth * std::sin(theta), 0.1 * (i % 5 - 2)};
    point.cameras = {2, 3, 4, 5};
    poses.points.push_back(point);
    poses.sightings.emplace_back(4, Eigen::Vector2d(70, 40));
  }
  return poses;
}

ArcFit simple_fit() {
  ArcFit fit;
  fit.arc.radius = 1;
  fit.arc.theta_begin = -0.5, fit.arc.theta_end = 0.5;
  return fit;
}

struct Laid {
  Poses poses = simple_poses();
  ArcFit fit = simple_fit();
  BuildOptions options;
  std::vector<std::string> notes;
  GridLayout layout() { return {poses, fit, options, notes}; }
};

std::string refusal(Laid& laid) {
  try {
    laid.layout();
  } catch (const Impossible& error) {
    return std::string("impossible: ") + error.what();
  } catch (const std::invalid_argument& error) {
    return std::string("invalid: ") + error.what();
  }
  return "";
}

TEST(GridLayout, IsTheFinestWhereMemoryIsEnough) {
  Laid laid;
  const GridLayout layout = laid.layout();
  EXPECT_EQ(layout.pitch_px(), 1);
  EXPECT_NEAR(layout.grid().theta_pitch, 1.0 / test::kFocal, 1e-12);
  EXPECT_GT(layout.grid().w_near, layout.grid().w_far);
  EXPECT_THAT(laid.notes, IsEmpty());
}

TEST(GridLayout, IsAsFineAsTheEffortSays) {
  Laid standard;
  const PanoramaGrid usual = standard.layout().grid();
  for (const Effort effort : {Effort::fast, Effort::best}) {
    const double pitch_px = options_of(effort).pitch_px;
    Laid laid;
    laid.options.effort = effort;
    EXPECT_EQ(laid.layout().pitch_px(), pitch_px);
    EXPECT_NEAR(laid.layout().grid().width * pitch_px, usual.width, 2);
    EXPECT_NEAR(laid.layout().grid().height * pitch_px, usual.height, 2);
    EXPECT_THAT(laid.notes, IsEmpty());
  }
  EXPECT_GT(options_of(Effort::fast).pitch_px, 1);
  EXPECT_LT(options_of(Effort::best).pitch_px, 1);
}

TEST(GridLayout, IsNoFinerThanMemoryAllowsWhateverTheEffort) {
  Laid standard, best;
  const GridLayout usual = standard.layout();
  best.options.effort = Effort::best;
  best.options.memory_bytes =
      expected_memory(usual.grid(), usual.columns_of_colour(), 140 * 80, 9 * 140 * 80, best.options.layers).all;
  const GridLayout layout = best.layout();
  EXPECT_GT(layout.pitch_px(), options_of(Effort::best).pitch_px);
  EXPECT_NEAR(layout.pitch_px(), 1, 0.1);
  ASSERT_EQ(best.notes.size(), 1U);
  EXPECT_THAT(best.notes[0], HasSubstr("to fit the memory allowed"));
}

TEST(GridLayout, IsCoarserWhereTheCameraWalkedForwardAndSaysSo) {
  Laid laid;
  laid.fit.forward = true;
  EXPECT_EQ(laid.layout().pitch_px(), 2.5);
  ASSERT_EQ(laid.notes.size(), 1U);
  EXPECT_THAT(laid.notes[0], AllOf(HasSubstr("moved along its line of sight"), HasSubstr("spans 2.5 of the photos'")));
}

TEST(GridLayout, IsAsFineAsEverWhereTheCameraTurnedOnTheSpotOrUpwards) {
  Laid on_the_spot, upwards;
  on_the_spot.fit.forward = upwards.fit.forward = true;
  on_the_spot.poses.report.motion = Motion::rotation;
  for (Camera& camera : upwards.poses.cameras)
    camera.pose.world_from_camera *= (Eigen::Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished();
  for (Laid* laid : {&on_the_spot, &upwards}) {
    EXPECT_EQ(laid->layout().pitch_px(), 1);
    EXPECT_THAT(laid->notes, IsEmpty());
  }
}

TEST(GridLayout, IsCoarserByAsLittleAsMemoryAsksForAndSaysSo) {
  Laid all;
  const GridLayout finest = all.layout();
  const auto needed = [&](const PanoramaGrid& grid, int columns) {
    return expected_memory(grid, columns, 140 * 80, 9 * 140 * 80, all.options.layers).all;
  };
  Laid less;
  less.options.memory_bytes = needed(finest.grid(), finest.columns_of_colour()) - 150'000;
  const GridLayout coarser = less.layout();
  EXPECT_GT(coarser.pitch_px(), 1);
  EXPECT_LT(coarser.grid().width, finest.grid().width);
  ASSERT_EQ(less.notes.size(), 1U);
  EXPECT_EQ(less.notes[0], "to fit the memory allowed, a row of the panorama spans " +
                               std::to_string(coarser.pitch_px()).substr(0, 4) + " of the photos'");
  double before = coarser.pitch_px();
  for (int i = 0; i < 3 && refusal(less).empty(); ++i) {
    less.options.memory_bytes -= 100'000;
    less.notes.clear();
    if (!refusal(less).empty()) break;
    const double pitch = less.layout().pitch_px();
    EXPECT_GE(pitch, before) << "less memory, a finer grid";
    before = pitch;
  }
}

TEST(GridLayout, TooLittleMemoryIsRefusedWithWhatWouldDo) {
  Laid laid;
  laid.options.memory_bytes = 1 << 20;
  EXPECT_THAT(refusal(laid), AllOf(HasSubstr("impossible: this sweep needs at least "),
                                   HasSubstr(" MiB of memory, 1 MiB are allowed (memory_bytes)")));
  laid.options.memory_bytes = 1000;
  EXPECT_THAT(refusal(laid), HasSubstr(" of memory, 1000 bytes are allowed"));
}

// Of photos as large as asked for, in which nothing is closer together.
void enlarge(Laid& laid, double times) {
  for (Camera& camera : laid.poses.cameras) {
    Intrinsics& k = camera.intrinsics;
    k.width = static_cast<int>(k.width * times), k.height = static_cast<int>(k.height * times);
    k.fx *= times, k.fy *= times, k.cx *= times, k.cy *= times;
  }
}

TEST(GridLayout, ASecondColumnOfColourIsGivenUpBeforeRowsAre) {
  Laid all;
  for (ScenePoint& point : all.poses.points) point.position *= 1.5 / std::hypot(point.position.x(), point.position.y());
  enlarge(all, 10);
  const GridLayout finest = all.layout();
  ASSERT_EQ(finest.columns_of_colour(), 2);
  const auto needed = [&](int columns) {
    return expected_memory(finest.grid(), columns, 1400 * 800, 9 * 1400 * 800, all.options.layers).all;
  };
  ASSERT_LT(needed(1), needed(2));
  Laid less = all;
  less.options.memory_bytes = needed(2) - 1;
  const GridLayout layout = less.layout();
  EXPECT_EQ(layout.pitch_px(), 1);
  EXPECT_EQ(layout.columns_of_colour(), 1);
  EXPECT_EQ(layout.grid().width, finest.grid().width);
  EXPECT_THAT(less.notes, IsEmpty());
}

int64_t colour_pixels(const GridLayout& layout) {
  return int64_t{layout.grid().width} * layout.columns_of_colour() * layout.grid().height;
}

TEST(GridLayout, IsCoarserByAsLittleAsAFileAsksForAndSaysSo) {
  Laid within, beyond;
  enlarge(within, 80), enlarge(beyond, 150);
  EXPECT_EQ(within.layout().pitch_px(), 1);
  EXPECT_THAT(within.notes, IsEmpty());
  const GridLayout layout = beyond.layout();
  EXPECT_GT(layout.pitch_px(), 1);
  EXPECT_LE(colour_pixels(layout), kMaxLdpPixels);
  EXPECT_GT(static_cast<double>(colour_pixels(layout)), static_cast<double>(kMaxLdpPixels) / 1.05 / 1.06);
  ASSERT_EQ(beyond.notes.size(), 1U);
  EXPECT_EQ(beyond.notes[0], "to fit a file, a row of the panorama spans " +
                                 std::to_string(layout.pitch_px()).substr(0, 4) + " of the photos'");
}

TEST(GridLayout, IsCoarserWhereAFileHoldsNoGridSoWideOrSoHigh) {
  Laid wide, high;
  enlarge(wide, 400), enlarge(high, 170);
  for (Camera& camera : wide.poses.cameras)  // a strip of it
    camera.intrinsics.height = 800, camera.intrinsics.cy = 400;
  for (Camera& camera : high.poses.cameras) {
    Intrinsics& k = camera.intrinsics;
    k.height = 23'000, k.cy = 11'500, k.width = 2000, k.cx = 1000;
  }
  const GridLayout widest = wide.layout(), highest = high.layout();
  EXPECT_GT(widest.pitch_px(), 1);
  EXPECT_LE(widest.grid().width * widest.columns_of_colour(), kMaxLdpWidth);
  EXPECT_GT(widest.grid().width, kMaxLdpWidth * 0.9);
  EXPECT_GT(highest.pitch_px(), 1);
  EXPECT_LE(highest.grid().height, kMaxLdpHeight);
  EXPECT_GT(highest.grid().height, kMaxLdpHeight * 0.9);
}

TEST(GridLayout, PhotosOfWhichNoFileHoldsAPanoramaAreRefused) {
  Laid laid;
  enlarge(laid, 1500);
  EXPECT_THAT(refusal(laid), AllOf(HasSubstr("impossible: the panorama would have at least "),
                                   HasSubstr(" pixels, more than a file holds: use smaller or fewer photos")));
}

TEST(GridLayout, ScratchFilesAreOpenedOnlyWhereMemoryEndsAndTheirFailureIsNoEnd) {
  Laid laid;
  laid.options.scratch_directory = testing::TempDir();
  EXPECT_EQ(laid.layout().give_scratch(), nullptr) << "everything fits";
  laid.options.memory_bytes = 30'000'000;
  laid.options.scratch_directory = "/nowhere/at/all";
  EXPECT_THAT(refusal(laid), HasSubstr("impossible: this sweep needs at least"));
  EXPECT_THAT(laid.notes, testing::ElementsAre(HasSubstr("everything is kept in memory: ")));
}

TEST(GridLayout, DepthsOnTheWrongSideAreRefusedByTheirNames) {
  Laid laid;
  laid.options.far_depth = 0.01;
  EXPECT_THAT(refusal(laid), AllOf(HasSubstr("invalid: far_depth 0.01: is nearer than what is nearest in the photos"),
                                   HasSubstr("give a larger one, or near_depth too")));
  laid.options.far_depth = 0;
  laid.options.near_depth = 1e6;
  EXPECT_THAT(refusal(laid), AllOf(HasSubstr("invalid: near_depth 1e+06: is farther than what is farthest"),
                                   HasSubstr("give a smaller one, or far_depth too")));
  laid.poses.report.motion = Motion::rotation;
  EXPECT_FALSE(has_parallax(laid.poses));
  EXPECT_EQ(refusal(laid), "") << "without parallax no depth is told";
}

TEST(ExpectedMemory, GrowsWithEverythingAndIsLeastWithAScratchSpace) {
  PanoramaGrid grid = test::simple_grid(0.5);
  grid.width = 4000, grid.height = 1000;
  const auto memory = [&](int columns, size_t photo_px, size_t upright_px, int layers) {
    return expected_memory(grid, columns, photo_px, upright_px, layers);
  };
  const ExpectedMemory usual = memory(1, 1'000'000, 40'000'000, 3);
  EXPECT_LT(usual.least, usual.all);
  EXPECT_GE(memory(2, 1'000'000, 40'000'000, 3).all, usual.all);
  EXPECT_GT(memory(1, 2'000'000, 40'000'000, 3).all, usual.all);
  EXPECT_GT(memory(1, 1'000'000, 80'000'000, 3).all, usual.all);
  EXPECT_GT(memory(1, 1'000'000, 40'000'000, 8).all, usual.all);
  EXPECT_EQ(memory(1, 1'000'000, 80'000'000, 3).least, usual.least) << "upright frames live in files";
  grid.width = 10, grid.height = 10;
  const ExpectedMemory tiny = memory(1, 100, 100, 1);
  EXPECT_EQ(tiny.least, tiny.all) << "where there is nothing to put into files";
}

// --- layers ----------------------------------------------------------------------------------------------------------

struct Found {
  explicit Found(std::vector<uint16_t> disparities) {
    for (const uint16_t d : disparities) {
      layers.emplace_back(grid.width, grid.height, d);
      sources.emplace_back(grid.width, grid.height, 3);
      for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) sources.back().set(x, y, 1);
    }
  }
  std::vector<Layer> coded() { return code_layers(grid, 1, 16, layers, sources); }

  PanoramaGrid grid = test::simple_grid(0.5);
  std::vector<DisparityMap> layers;
  std::vector<SourceMap> sources;
};

int64_t present(const Layer& layer) {
  return std::count(layer.coverage.samples.begin(), layer.coverage.samples.end(), uint8_t{1});
}

TEST(CodeLayers, KeepDepthsToWithinWhatIsKnown) {
  Found found({3000, 500});
  const std::vector<Layer> layers = found.coded();
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_EQ(present(layers[0]), found.grid.width * found.grid.height);
  EXPECT_EQ(present(layers[1]), found.grid.width * found.grid.height);
  for (int y = 0; y < found.grid.height; y += 7)
    for (int x = 0; x < found.grid.width; x += 7) {
      EXPECT_NEAR(layers[0].depth.disparity(x, y), 3000, 400);
      EXPECT_NEAR(layers[1].depth.disparity(x, y), 500, 500);
    }
  EXPECT_EQ(layers[0].colour.width, found.grid.width);
}

TEST(CodeLayers, WhatARendererCouldNotTellFromTheFrontIsDropped) {
  Found found({2000, 1990});
  const std::vector<Layer> layers = found.coded();
  EXPECT_EQ(present(layers[1]), 0);
  EXPECT_EQ(found.layers[1].at(5, 5), kNoDisparity);
  EXPECT_EQ(found.sources[1].at(5, 5), kNoSource);
  EXPECT_EQ(found.sources[0].at(5, 5), 1);
}

TEST(CodeLayers, SpecksAreDroppedBehindAndKeptInFront) {
  Found found({3000, 500});
  for (DisparityMap& layer : found.layers) std::fill(layer.samples.begin(), layer.samples.end(), kNoDisparity);
  for (int i = 0; i < pipeline::kSpeckPx - 1; ++i)
    found.layers[0].at(10 + i, 10) = 3000, found.layers[1].at(50 + i, 40) = 500;
  for (int i = 0; i < pipeline::kSpeckPx; ++i) found.layers[1].at(50 + i, 20) = 500;
  const std::vector<Layer> layers = found.coded();
  EXPECT_EQ(present(layers[0]), pipeline::kSpeckPx - 1);
  EXPECT_EQ(present(layers[1]), pipeline::kSpeckPx);
  EXPECT_EQ(layers[1].coverage.at(50, 40), 0);
  EXPECT_EQ(found.sources[1].at(50, 40), kNoSource);
  EXPECT_EQ(found.sources[1].at(50, 20), 1);
}

TEST(CodeLayers, BehindWhatIsAbsentAnythingIsKept) {
  Found found({2000, 1990});
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 50; ++x) found.layers[0].at(x, y) = kNoDisparity;
  const std::vector<Layer> layers = found.coded();
  EXPECT_EQ(layers[1].coverage.at(20, 30), 1);
  EXPECT_EQ(layers[1].coverage.at(80, 30), 0);
  EXPECT_EQ(layers[0].coverage.at(20, 30), 0);
}

// --- small parts -----------------------------------------------------------------------------------------------------

TEST(Stopwatch, AddsLapsOfOneNameAndKeepsTheirOrder) {
  std::vector<std::pair<std::string, double>> seconds, processor_seconds;
  Stopwatch watch(seconds, processor_seconds);
  for (const char* const stage : {"poses", "solve", "poses", "refine", "solve"}) watch.lap(stage);
  for (const auto& of : {seconds, processor_seconds}) {
    ASSERT_EQ(of.size(), 3U);
    EXPECT_EQ(of[0].first, "poses");
    EXPECT_EQ(of[1].first, "solve");
    EXPECT_EQ(of[2].first, "refine");
    for (const auto& [stage, time] : of) EXPECT_GE(time, 0) << stage;
  }
}

TEST(PoseEvidence, TellsMotionAndDoubtsByTheVerdictsNames) {
  Poses poses = simple_poses();
  SweepEvidence evidence;
  evidence.photos.resize(poses.cameras.size());
  poses.report.reprojection_px = 0.7;
  add_pose_evidence(poses, 12, evidence);
  EXPECT_EQ(evidence.photos_taken, 12);
  poses.report.frames.resize(12);
  const LeftOutCause causes[] = {LeftOutCause::repeated, LeftOutCause::needless, LeftOutCause::unmatched};
  for (size_t i = 0; i < 3; ++i) poses.report.frames[i].left_out.cause = causes[i];
  add_pose_evidence(poses, 12, evidence);
  EXPECT_EQ(evidence.photos_taken, 10) << "what two of them show is seen all the same";
  EXPECT_DOUBLE_EQ(evidence.reprojection, 0.7 / 140);
  for (Camera& camera : poses.cameras) camera.intrinsics.height = 280;
  add_pose_evidence(poses, 12, evidence);
  EXPECT_DOUBLE_EQ(evidence.reprojection, 0.7 / 280) << "of photos that stand upright, too, the longer side counts";
  EXPECT_NEAR(evidence.photos[3].turn_deg, 0.125 * 180 / 3.14159265, 1.0 / 256);
  EXPECT_EQ(evidence.photos[3].shared_points, 200);
  EXPECT_EQ(evidence.photos[2].shared_points, 0);
  const std::pair<Motion, SweepMotion> motions[] = {{Motion::arc, SweepMotion::arc},
                                                    {Motion::straight, SweepMotion::straight},
                                                    {Motion::rotation, SweepMotion::rotation}};
  for (const auto& [told, wanted] : motions) {
    poses.report.motion = told;
    add_pose_evidence(poses, 9, evidence);
    EXPECT_EQ(evidence.motion, wanted);
  }
  const std::pair<PoseDoubt, DoubtfulPoses> doubts[] = {{PoseDoubt::none, DoubtfulPoses::no},
                                                        {PoseDoubt::contradicted, DoubtfulPoses::contradicted},
                                                        {PoseDoubt::unrelated, DoubtfulPoses::contradicted},
                                                        {PoseDoubt::loose, DoubtfulPoses::loose},
                                                        {PoseDoubt::in_pairs, DoubtfulPoses::loose},
                                                        {PoseDoubt::lens, DoubtfulPoses::lens}};
  for (const auto& [told, wanted] : doubts) {
    poses.report.doubt_kind = told;
    add_pose_evidence(poses, 9, evidence);
    EXPECT_EQ(evidence.doubt, wanted);
  }
}

}  // namespace
}  // namespace ldp
