// What is lighter or darker than what is around it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stop_token>

#include "core/layers/layers.h"
#include "tests/unit/square_before_sky.h"

namespace ldp {
namespace {

using namespace test;

constexpr int kReach = 6, kBar = 48, kBarEnd = 52, kBeam = 26, kBeamEnd = 30;

enum class Thing : uint8_t { bar, beam };  // down those columns of the panorama, across those rows

// A grey sky, with a thing of another grey in it.
std::vector<UprightFrame> thing_in_the_sky(const PanoramaGrid& grid, int grey, Thing thing = Thing::bar) {
  const auto shown = [&](const Eigen::Vector3d&, const Eigen::Vector3d& ray) {
    const double column = (grid.theta_left - std::atan2(ray.y(), ray.x())) / grid.theta_pitch;
    const double row = (grid.v_top - ray.z() / std::hypot(ray.x(), ray.y())) / grid.v_pitch;
    const bool there = thing == Thing::bar ? column >= kBar && column < kBarEnd : row >= kBeam && row < kBeamEnd;
    return there ? grey : 100.0;
  };
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 3; ++i) frames.push_back(photograph(0.25 - 0.25 * i, i, shown));
  return frames;
}

TEST(Lightness, OfABarAndOfWhatIsBesideIt) {
  const PanoramaGrid grid = simple_grid(0.5);
  const DisparityMap layer(grid.width, grid.height, 0);
  const auto of_bar = [&](int grey) { return lightness(grid, thing_in_the_sky(grid, grey), layer, kReach, {}); };
  const Plane<Lightness> white = of_bar(140), black = of_bar(60), faint = of_bar(104);
  for (const int y : {0, grid.height / 2, grid.height - 1}) {
    for (const int bar : {kBar + 1, kBarEnd - 2}) {
      EXPECT_EQ(white.at(bar, y), Lightness::lighter) << bar << ", " << y;
      EXPECT_EQ(black.at(bar, y), Lightness::darker);
      EXPECT_EQ(faint.at(bar, y), Lightness::as_around);
    }
    for (const int beside : {kBar - 3, kBarEnd + 2}) {
      EXPECT_EQ(white.at(beside, y), Lightness::darker) << beside << ", " << y;
      EXPECT_EQ(black.at(beside, y), Lightness::lighter);
    }
    for (const int away : {0, kBar - kReach - 2, kBarEnd + kReach + 1}) {
      EXPECT_EQ(white.at(away, y), Lightness::as_around) << away << ", " << y;
      EXPECT_EQ(black.at(away, y), Lightness::as_around);
    }
  }
}

// A row of the beam makes a mean of 103, two make one of 106.
TEST(Lightness, OfWhatIsAboveAndBelowABeam) {
  const PanoramaGrid grid = simple_grid(0.5);
  const Plane<Lightness> found =
      lightness(grid, thing_in_the_sky(grid, 140, Thing::beam), DisparityMap(grid.width, grid.height, 0), kReach, {});
  const auto of_row = [&](int y) { return found.at(grid.width / 2, y); };
  EXPECT_EQ(of_row(kBeam + 1), Lightness::lighter);
  EXPECT_EQ(of_row(kBeam - kReach), Lightness::as_around);
  EXPECT_EQ(of_row(kBeam - kReach + 1), Lightness::darker);
  EXPECT_EQ(of_row(kBeamEnd + kReach - 2), Lightness::darker);
  EXPECT_EQ(of_row(kBeamEnd + kReach - 1), Lightness::as_around);
}

// What lies beside an absent bar has nothing to differ from.
TEST(Lightness, AbsentPixelsAreNotLookedAt) {
  const PanoramaGrid grid = simple_grid(0.5);
  DisparityMap layer(grid.width, grid.height, 0);
  for (int y = 0; y < grid.height; ++y)
    for (int x = kBar - 1; x <= kBarEnd; ++x) layer.at(x, y) = kNoDisparity;
  EXPECT_EQ(lightness(grid, thing_in_the_sky(grid, 200), layer, kReach, {}),
            Plane<Lightness>(grid.width, grid.height, Lightness::as_around));
  EXPECT_EQ(lightness(grid, {}, layer, kReach, {}), Plane<Lightness>(grid.width, grid.height, Lightness::as_around));
}

TEST(Lightness, DoesNotDependOnTheSeamNorOnThreadsAndStopsWhenAsked) {
  const auto frames = photographs_of_the_square(simple_grid(0.5), Plain::nothing);
  const PanoramaGrid grid = closed_grid(320);
  const DisparityMap layer(grid.width, grid.height, 0);
  Job job;
  const Plane<Lightness> whole = lightness(grid, frames, layer, kReach, job);
  EXPECT_GT(std::count(whole.samples.begin(), whole.samples.end(), Lightness::lighter), 1000);
  for (const int seam : {0, 1, 25})
    EXPECT_EQ(lightness(closed_grid(seam), frames, layer, kReach, job), rotated(whole, seam - 320 + grid.width));
  job.threads = 4;
  EXPECT_EQ(lightness(grid, frames, layer, kReach, job), whole);
  std::stop_source source;
  source.request_stop();
  job.stop = source.get_token();
  EXPECT_THROW(lightness(grid, frames, layer, kReach, job), Cancelled);
}

}  // namespace
}  // namespace ldp
