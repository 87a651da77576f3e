// Which part of a grid photographs see, and panoramas cut down to what they see.
#include "core/pipeline/seen_part.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/arc/arc.h"
#include "core/pipeline/crop.h"
#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

constexpr int kFarOff = 12;  // pixels from what is seen within which more may count as seen

PanoramaGrid grid_of(int width, int height) {
  PanoramaGrid grid;
  grid.arc.radius = 1;
  grid.width = width, grid.height = height;
  grid.theta_pitch = 0.01, grid.theta_left = 0.5 * width * grid.theta_pitch;
  grid.v_pitch = 0.01, grid.v_top = 0.5 * height * grid.v_pitch;
  grid.w_far = 0.1, grid.w_near = 0.5;
  return grid;
}

// Looks outward from the circle at an angle; its rows `first` to the last but as many are the photo's.
UprightFrame frame_at(double theta, int width, int height, int first) {
  UprightFrame frame;
  UprightCamera& camera = frame.camera;
  camera.centre = {std::cos(theta), std::sin(theta), 0.05};
  camera.forward = {std::cos(theta), std::sin(theta), 0};
  camera.right = {std::sin(theta), -std::cos(theta), 0};
  camera.focal = 100;
  camera.width = width, camera.height = height;
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
  frame.columns = GreyImage(height, width);
  frame.tint = frame.columns;
  frame.valid_begin.assign(static_cast<size_t>(width), static_cast<int16_t>(first));
  frame.valid_end.assign(static_cast<size_t>(width), static_cast<int16_t>(height - first));
  return frame;
}

bool sees(const UprightFrame& frame, const Eigen::Vector3d& point) {
  const UprightCamera& camera = frame.camera;
  const Eigen::Vector3d q = point - camera.centre;
  const double forward = q.dot(camera.forward), x = camera.focal * q.dot(camera.right) / forward + camera.cx,
               y = camera.cy - camera.focal * q.z() / forward;
  if (forward <= 0 || x < 0 || x >= camera.width) return false;
  return y >= frame.valid_begin[static_cast<size_t>(x)] && y < frame.valid_end[static_cast<size_t>(x)];
}

Plane<uint8_t> seen_at_any_depth(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid) {
  Plane<uint8_t> seen(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      for (int step = 0; step <= 60; ++step)
        for (const UprightFrame& frame : frames) {
          const double w = grid.inverse_depth(step * kDisparitySteps / 60.0);
          if (sees(frame, grid.point(grid.theta(x + 0.5), grid.v(y + 0.5), w))) seen.at(x, y) = 1;
        }
  return seen;
}

bool any_within(const Plane<uint8_t>& seen, int x, int y, int reach) {
  for (int j = y - reach; j <= y + reach; ++j)
    for (int i = x - reach; i <= x + reach; ++i)
      if (seen.contains(i, j) && seen.at(i, j)) return true;
  return false;
}

TEST(SeenPart, HoldsAllThatAPhotoSeesAtAnyDepthAndLittleElse) {
  const std::vector<UprightFrame> frames{frame_at(0.3, 60, 80, 10), frame_at(-0.3, 60, 80, 25)};
  const PanoramaGrid grid = grid_of(240, 200);
  const SeenPart part = find_seen_part(frames, grid, Job{});
  const Plane<uint8_t> truth = seen_at_any_depth(frames, grid);
  ASSERT_EQ(part.mask.width, part.box.width);
  ASSERT_EQ(part.mask.height, part.box.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const int i = x - part.box.x, j = y - part.box.y;
      const bool held = part.mask.contains(i, j) && part.mask.at(i, j) != 0;
      ASSERT_TRUE(held || !truth.at(x, y)) << x << ' ' << y;
      ASSERT_TRUE(!held || any_within(truth, x, y, kFarOff)) << x << ' ' << y;
    }
}

TEST(SeenPart, IsAllOfAGridThatPhotosSeeOrThatIsTiny) {
  const std::vector<UprightFrame> frames{frame_at(0, 400, 400, 0)};
  const PanoramaGrid small = grid_of(100, 60), tiny = grid_of(20, 200);
  EXPECT_TRUE(find_seen_part(frames, small, Job{}).mask.empty());
  EXPECT_EQ(find_seen_part(frames, small, Job{}).box.width, 100);
  EXPECT_EQ(find_seen_part({}, tiny, Job{}).box.height, 200);
}

TEST(SeenPart, LeavesNoRowsWhereNothingIsSeenAtTheSides) {
  const PanoramaGrid grid = grid_of(240, 400);
  const SeenPart part = find_seen_part({frame_at(0, 60, 80, 10)}, grid, Job{});
  EXPECT_LT(part.box.height, 160);
  EXPECT_LT(part.box.width, 160);
  const PanoramaGrid cut = part_of(grid, part.box.x, part.box.y, part.box.width, part.box.height);
  EXPECT_DOUBLE_EQ(cut.theta(3.5), grid.theta(part.box.x + 3.5));
  EXPECT_DOUBLE_EQ(cut.v(7.5), grid.v(part.box.y + 7.5));
}

// A layer that is present in a box.
DisparityMap present_in(const Window& box, int width, int height) {
  DisparityMap layer(width, height, kNoDisparity);
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) layer.at(x, y) = 7;
  return layer;
}

void expect_box(const Window& box, const Window& expected) {
  EXPECT_EQ(box.x, expected.x);
  EXPECT_EQ(box.y, expected.y);
  EXPECT_EQ(box.width, expected.width);
  EXPECT_EQ(box.height, expected.height);
}

TEST(SeenBox, CutsRowsAndColumnsOfWhichLessThanATwentiethIsSeen) {
  DisparityMap layer = present_in({30, 10, 100, 60}, 200, 100);
  layer.at(50, 9) = 7;                                // one pixel of 100: not worth a row
  for (int x = 60; x < 65; ++x) layer.at(x, 70) = 7;  // five of 100: a twentieth is
  expect_box(seen_box({layer}, false), {30, 10, 100, 61});
  expect_box(seen_box({layer, present_in({0, 40, 30, 20}, 200, 100)}, false), {0, 10, 130, 60});
}

TEST(SeenBox, KeepsAllColumnsOfAPanoramaThatWrapsAndAllOfAnEmptyOne) {
  expect_box(seen_box({present_in({30, 10, 100, 60}, 200, 100)}, true), {0, 10, 200, 60});
  expect_box(seen_box({present_in({0, 0, 0, 0}, 20, 10)}, false), {0, 0, 20, 10});
}

// Looks again at what it is asked of.
Window box_by_looking(const DisparityMap& layer) {
  Window box{0, 0, layer.width, layer.height};
  for (const int least_seen : {1'000'000, 20}) {
    const auto hardly = [&](const Window& part) {
      int seen = 0;
      for (int y = part.y; y < part.y + part.height; ++y)
        for (int x = part.x; x < part.x + part.width; ++x) seen += layer.at(x, y) != kNoDisparity ? 1 : 0;
      return seen * least_seen < part.width * part.height;
    };
    for (bool trimmed = true; trimmed && box.width > 0 && box.height > 0;) {
      if (hardly({box.x, box.y, box.width, 1})) {
        ++box.y, --box.height;
      } else if (hardly({box.x, box.y + box.height - 1, box.width, 1})) {
        --box.height;
      } else if (hardly({box.x, box.y, 1, box.height})) {
        ++box.x, --box.width;
      } else if (hardly({box.x + box.width - 1, box.y, 1, box.height})) {
        --box.width;
      } else {
        trimmed = false;
      }
    }
  }
  return box;
}

// What a row has of a column that goes is no longer counted, and the other way round.
TEST(SeenBox, IsThatOfLookingAgainAtEachRowAndColumn) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 30; ++trial) {
    DisparityMap layer = present_in({20, 12, 30, 20}, 70, 50);
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x)
        if (static_cast<int>(random() % 1000) < (x + y) % 90) layer.at(x, y) = 7;
    expect_box(seen_box({layer}, false), box_by_looking(layer));
  }
}

TEST(Crop, KeepsTheBoxOfAllPlanesAndTheirPlaceOnTheGrid) {
  const PanoramaGrid grid = grid_of(8, 4);
  std::vector<DisparityMap> layers(2, present_in({2, 1, 3, 2}, 8, 4));
  std::vector<SourceMap> sources{SourceMap(8, 4, 3), SourceMap(8, 4, 3000)};
  std::vector<Plane<uint8_t>> neighbours(2, Plane<uint8_t>(8, 4));
  sources[0].set(2, 1, 1), sources[1].set(4, 2, 2999);
  neighbours[1].at(3, 1) = 5;
  const PanoramaGrid cut = crop_to_seen(grid, {layers, sources, neighbours});
  EXPECT_EQ(cut.width, 3);
  EXPECT_EQ(cut.height, 2);
  EXPECT_DOUBLE_EQ(cut.theta(0.5), grid.theta(2.5));
  EXPECT_DOUBLE_EQ(cut.v(0.5), grid.v(1.5));
  EXPECT_EQ(layers[0], DisparityMap(3, 2, uint16_t{7}));
  EXPECT_EQ(sources[0].at(0, 0), 1);
  EXPECT_EQ(sources[0].at(1, 0), kNoSource);
  EXPECT_EQ(sources[1].width(), 3);
  EXPECT_EQ(sources[1].at(2, 1), 2999);
  EXPECT_EQ(neighbours[1].at(1, 0), 5);
}

}  // namespace
}  // namespace ldp
