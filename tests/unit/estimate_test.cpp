// What a build will take, told before it: known answers where nothing has to be scaled, and the limits of memory.
#include "core/estimate/estimate.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/estimate/small_frames.h"
#include "core/panorama/file/ldp_file.h"
#include "core/pipeline/memory_budget.h"
#include "sim/scene_capture.h"
#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Sweep {
  test::FramesInMemory frames{{}};
  BuildOptions options;  // with the cameras that took them, and little to do
  Job job;
};

// A quarter of a circle in a room.
Sweep photograph(int width, int height) {
  SceneCaptureOptions scene;
  scene.scene = "room";
  scene.path.frames = 6, scene.path.arc_rad = 1.5;
  scene.path.width = width, scene.path.height = height;
  const SceneSweep sweep(scene);
  std::vector<RgbImage> images;
  for (int i = 0; i < scene.path.frames; ++i) images.push_back(sweep.take(i, {}).colour);
  Sweep result{test::FramesInMemory(std::move(images)), {}, {}};
  result.options.cameras = sweep.cameras();
  for (int i = 0; i < scene.path.frames; ++i)
    result.options.cameras[static_cast<size_t>(i)].name = result.frames.name(i);
  result.options.layers = 8;  // that memory is reckoned for
  result.options.labels = 4, result.options.effort = Effort::fast;
  return result;
}

class Estimate : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    small_ = new Sweep(photograph(200, 150));
    large_ = new Sweep(photograph(480, 360));
    whole_ = new BuildEstimate(of(*large_));
  }
  static void TearDownTestSuite() { delete small_, delete large_, delete whole_; }

  static BuildEstimate of(const Sweep& sweep) { return estimate_build(sweep.frames, sweep.options, {}, sweep.job); }
  static std::string refusal(const Sweep& sweep) {
    try {
      of(sweep);
    } catch (const Impossible& error) {
      return error.what();
    }
    return "";
  }

  static Sweep* small_;          // photos that are small enough as they are
  static Sweep* large_;          // and 2.4 times as wide and high
  static BuildEstimate* whole_;  // of the large ones, without a limit
};
Sweep* Estimate::small_ = nullptr;
Sweep* Estimate::large_ = nullptr;
BuildEstimate* Estimate::whole_ = nullptr;

TEST_F(Estimate, OfPhotosThatNeedNoScalingIsTheBuildItself) {
  const BuildEstimate told = of(*small_);
  const BuildResult built = build(small_->frames, small_->options, small_->job);
  EXPECT_EQ(told.width, built.panorama.grid.width);
  EXPECT_EQ(told.height, built.panorama.grid.height);
  const LaidGrid& laid = built.report.laid;
  PanoramaGrid grid;
  grid.width = laid.width, grid.height = laid.height;
  EXPECT_EQ(told.memory_bytes, expected_memory(grid, laid.columns_of_colour, 200 * 150, laid.upright_px, 8).all);
  EXPECT_EQ(told.scratch_bytes, 0U);
  const auto bytes = static_cast<double>(encode_ldp(built.panorama, {built.colour_quality}, {}).size());
  EXPECT_NEAR(static_cast<double>(told.file_bytes), bytes, 0.05 * bytes);
  EXPECT_GT(told.processor_seconds, 0);
  EXPECT_GT(told.spent_seconds, 0);
}

TEST_F(Estimate, OfLargerPhotosIsThatOfTheirSize) {
  EXPECT_NEAR(whole_->width, of(*small_).width * 480.0 / 200, 0.05 * whole_->width);
  EXPECT_NEAR(whole_->height, of(*small_).height * 480.0 / 200, 0.05 * whole_->height);
  EXPECT_EQ(whole_->scratch_bytes, 0U);
}

TEST_F(Estimate, LessMemoryIsACoarserPanoramaWhereThereIsNoRoomForFiles) {
  Sweep less = *large_;
  less.options.memory_bytes = whole_->memory_bytes - 1'000'000;
  const BuildEstimate coarser = of(less);
  EXPECT_LT(coarser.width, whole_->width);
  EXPECT_LT(coarser.height, whole_->height);
  EXPECT_LE(coarser.memory_bytes, less.options.memory_bytes);
  EXPECT_GT(coarser.memory_bytes, less.options.memory_bytes - less.options.memory_bytes / 5);
  EXPECT_LT(coarser.file_bytes, whole_->file_bytes);
}

TEST_F(Estimate, LessMemoryIsFilesWhereThereIsRoomForThem) {
  Sweep less = *large_;
  less.options.memory_bytes = whole_->memory_bytes - 1'000'000;
  less.options.scratch_directory = testing::TempDir();
  const BuildEstimate in_files = of(less);
  EXPECT_EQ(in_files.width, whole_->width);
  EXPECT_EQ(in_files.height, whole_->height);
  EXPECT_EQ(in_files.memory_bytes, less.options.memory_bytes);
  EXPECT_GE(in_files.scratch_bytes, 1'000'000U);
}

TEST_F(Estimate, OfABuildThatNoMemoryAllowedIsEnoughForIsItsRefusal) {
  for (const char* const scratch : {"", "/nowhere/at/all"}) {
    Sweep little = *small_;
    little.options.memory_bytes = 1 << 20;
    little.options.scratch_directory = scratch;
    EXPECT_THAT(refusal(little), AllOf(HasSubstr("this sweep needs at least "),
                                       HasSubstr(" MiB of memory, 1 MiB are allowed (memory_bytes)")));
  }
}

TEST_F(Estimate, IsOfThePhotosThatArePosedWhateverSizeTheFirstHas) {
  const RgbImage first = large_->frames.load(0);
  std::vector<RgbImage> images{RgbImage(90, 60)};
  for (int i = 1; i < large_->frames.size(); ++i) images.push_back(large_->frames.load(i));
  Sweep without{test::FramesInMemory(std::move(images)), large_->options, {}};
  without.options.cameras.erase(without.options.cameras.begin());
  const BuildEstimate told = of(without);
  EXPECT_LT(told.width, whole_->width);
  EXPECT_GT(told.width, whole_->width * 0.7);
  EXPECT_NEAR(told.height, whole_->height, 0.1 * whole_->height);
}

TEST(SmallFrames, KeepTheirShapeAndTellByHowMuchTheyAreSmaller) {
  const test::FramesInMemory source({RgbImage(10, 10), RgbImage(400, 300), RgbImage(300, 400)});
  const SmallFrames frames(source, 1, 7500, {});
  EXPECT_DOUBLE_EQ(frames.scale(), 4);
  EXPECT_EQ(std::pair(frames.full_width(), frames.full_height()), std::pair(400, 300));
  EXPECT_EQ(std::pair(frames.load(1).width, frames.load(1).height), std::pair(100, 75));
  EXPECT_EQ(std::pair(frames.load(2).width, frames.load(2).height), std::pair(75, 100));
  EXPECT_EQ(frames.name(2), source.name(2));
  const SmallFrames whole(source, 1, 120'000, {});
  EXPECT_EQ(whole.scale(), 1);
  EXPECT_EQ(whole.load(1).width, 400);
}

TEST(SmallFrames, PosesAreFittedToTheirPixels) {
  const test::FramesInMemory source({RgbImage(10, 10), RgbImage(401, 300)});
  const SmallFrames frames(source, 1, 7500, {});
  Poses poses;
  poses.cameras.push_back(test::camera_at(0.2));
  poses.cameras[0].intrinsics = {401, 300, 500, 500, 200, 150, 0.1, 0, 0, 0};
  poses.sightings = {{{401, 300}, {0, 150}}};
  poses.report.reprojection_px = 1;
  const Poses fit = fitted(poses, frames);
  const Intrinsics& k = fit.cameras[0].intrinsics;
  EXPECT_EQ(k.width, frames.load(1).width);
  EXPECT_EQ(k.height, frames.load(1).height);
  EXPECT_NEAR(k.fx, 125, 0.5);
  EXPECT_NEAR(k.cy, 37.5, 0.1);
  EXPECT_EQ(k.k1, 0.1);
  EXPECT_EQ(fit.cameras[0].pose.centre, poses.cameras[0].pose.centre);
  EXPECT_DOUBLE_EQ(fit.sightings[0][0].x(), k.width);
  EXPECT_DOUBLE_EQ(fit.sightings[0][0].y(), k.height);
  EXPECT_NEAR(fit.report.reprojection_px, 0.25, 0.001);
}

}  // namespace
}  // namespace ldp
