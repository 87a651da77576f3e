// Colours read out of a photograph, where its camera projects a voxel.
#include "core/colour/photo_sampler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/simple_capture.h"

namespace ldp::colour {
namespace {

// Rising by one level a pixel to the right, two downwards.
RgbImage ramp(int width, int height) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = {static_cast<uint8_t>(x), static_cast<uint8_t>(2 * y), 77};
  return image;
}

Eigen::Vector2d place_of(const PanoramaGrid& grid, const Camera& camera, int x, int y, double w) {
  const Eigen::Vector3d p = grid.point(grid.theta(x + 0.5), grid.v(y + 0.5), w) - camera.pose.centre;
  return project(camera.intrinsics, camera.pose.world_from_camera.transpose() * p);
}

class Samples : public testing::TestWithParam<double> {};

TEST_P(Samples, OfARampAreItsValueAtTheProjectedPlace) {
  const PanoramaGrid grid = test::simple_grid(0.5);
  Camera camera = test::camera_at(0.03);
  camera.intrinsics.k1 = GetParam();
  const RgbImage photo = ramp(140, 80);
  const PhotoSampler sampler(grid, camera, {1, 1, 1});
  for (const double w : {0.05, 0.2, 0.5})
    for (int y = 15; y < 45; y += 6)
      for (int x = 20; x < 80; x += 7) {
        const Eigen::Vector2d at = place_of(grid, camera, x, y, w);
        if (at.x() < 3 || at.x() > 137 || at.y() < 3 || at.y() > 77) continue;
        const Colour colour = sampler.sample(photo, x, y, w);
        EXPECT_NEAR(colour[0], kColourSteps * (at.x() - 0.5), 0.65) << x << ", " << y << ", " << w;
        EXPECT_NEAR(colour[1], kColourSteps * 2 * (at.y() - 0.5), 0.8);
        EXPECT_EQ(colour[2], kColourSteps * 77);
        EXPECT_EQ(sampler.sample_if_inside(photo, x, y, w), colour);
      }
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutDistortion, Samples, testing::Values(0.0, 0.1));

TEST(PhotoSampler, GivesNothingOutsideThePictureOrBehindTheCamera) {
  const PanoramaGrid grid = test::simple_grid(0.5);
  const RgbImage photo = ramp(140, 80);
  const Camera aside = test::camera_at(-2);
  EXPECT_EQ(PhotoSampler(grid, aside, {1, 1, 1}).sample_if_inside(photo, 50, 30, 0.2), std::nullopt);
  Camera behind = test::camera_at(0);
  behind.pose.centre = {8, 0, 0};  // past the voxel, looking on
  EXPECT_EQ(PhotoSampler(grid, behind, {1, 1, 1}).sample_if_inside(photo, 50, 30, 0.5), std::nullopt);
  Camera narrow = test::camera_at(0);
  narrow.intrinsics.fx = narrow.intrinsics.fy = 1000;
  EXPECT_EQ(PhotoSampler(grid, narrow, {1, 1, 1}).sample_if_inside(photo, 5, 5, 0.2), std::nullopt);
  EXPECT_NE(PhotoSampler(grid, narrow, {1, 1, 1}).sample_if_inside(photo, 50, 30, 0.2), std::nullopt);
}

TEST(PhotoSampler, AppliesTheGainOfEachChannelAndStaysInBounds) {
  const PanoramaGrid grid = test::simple_grid(0.5);
  const RgbImage photo(140, 80, {100, 50, 250});
  const Colour plain = PhotoSampler(grid, test::camera_at(0), {1, 1, 1}).sample(photo, 50, 30, 0.2);
  EXPECT_EQ(plain, (Colour{1600, 800, 4000}));
  const RgbImage grey(140, 80, {100, 100, 100});
  const Colour gained = PhotoSampler(grid, test::camera_at(0), {0.5F, 1, 1.5F}).sample(grey, 50, 30, 0.2);
  EXPECT_NEAR(gained[0], 800, 2);
  EXPECT_NEAR(gained[1], 1600, 2);
  EXPECT_NEAR(gained[2], 2400, 2);
}

TEST(PhotoSampler, AveragesOverPixelsThatAreLargerThanThePhotographs) {
  PanoramaGrid coarse = test::simple_grid(0.5);
  coarse.theta_pitch *= 4, coarse.v_pitch *= 4, coarse.width /= 4, coarse.height /= 4;
  RgbImage stripes(140, 80);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 140; ++x) stripes.at(x, y) = x % 2 == 0 ? Rgb{60, 60, 60} : Rgb{140, 140, 140};
  const PhotoSampler sampler(coarse, test::camera_at(0), {1, 1, 1});
  for (int x = 9; x < 16; ++x) EXPECT_NEAR(sampler.sample(stripes, x, 7, 0.01)[0], 1600, 350) << x;

  int extremes = 0;
  const PanoramaGrid grid = test::simple_grid(0.5);
  const PhotoSampler sharp(grid, test::camera_at(0), {1, 1, 1});
  for (int x = 40; x < 60; ++x) extremes += std::abs(sharp.sample(stripes, x, 30, 0.01)[0] - 1600) > 400 ? 1 : 0;
  EXPECT_GT(extremes, 5) << "a grid as fine as the photograph shows its stripes";
}

}  // namespace
}  // namespace ldp::colour
