// Exposures of photographs that show the same things, and the words for photographs that take no part.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/photos/exposure_compensation.h"
#include "core/photos/exposure_tuning.h"
#include "core/photos/left_out.h"
#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

using testing::HasSubstr;

// From the same place, each turned by a quarter of its field of view from the one before.
std::vector<Camera> turning_cameras(int count) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    cameras.push_back(test::camera_at(-0.3 * i));
    cameras.back().pose.centre = Eigen::Vector3d::Zero();
  }
  return cameras;
}

// Smooth, between 60 and 140 levels, by direction.
double radiance(const Eigen::Vector3d& d, int channel) {
  return 100 + 40 * std::sin(5 * std::atan2(d.y(), d.x()) + 3 * d.z() / d.head<2>().norm() + channel);
}

RgbImage photo_of(const Camera& camera, const std::array<double, 3>& exposure) {
  RgbImage photo(camera.intrinsics.width, camera.intrinsics.height);
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      const Eigen::Vector3d d =
          camera.pose.world_from_camera * unproject(camera.intrinsics, Eigen::Vector2d(x + 0.5, y + 0.5));
      const auto level = [&](int channel) {
        return static_cast<uint8_t>(
            std::clamp(radiance(d, channel) * exposure[static_cast<size_t>(channel)], 0.0, 255.0));
      };
      photo.at(x, y) = {level(0), level(1), level(2)};
    }
  return photo;
}

std::vector<Gain> gains_of(const std::vector<Camera>& cameras, const std::vector<std::array<double, 3>>& exposures) {
  std::vector<Thumbnail> thumbnails;
  for (size_t i = 0; i < cameras.size(); ++i) thumbnails.push_back(make_thumbnail(photo_of(cameras[i], exposures[i])));
  return exposure_gains(cameras, thumbnails, {});
}

TEST(ExposureGains, OfEqualPhotographsAreOne) {
  for (const Gain& gain : gains_of(turning_cameras(6), std::vector<std::array<double, 3>>(6, {1, 1, 1})))
    for (const float g : gain) EXPECT_NEAR(g, 1, 0.01);
}

TEST(ExposureGains, BringEveryPhotographToTheExposureOfAll) {
  const std::vector<double> exposures{1, 1.3, 0.8, 1.1, 0.6, 0.9};
  std::vector<std::array<double, 3>> all;
  for (const double e : exposures) all.push_back({e, e, e});
  const std::vector<Gain> gains = gains_of(turning_cameras(6), all);
  for (size_t i = 0; i < gains.size(); ++i)
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(static_cast<double>(gains[i][c]) * exposures[i], static_cast<double>(gains[0][c]) * exposures[0],
                  0.02)
          << "photograph " << i;
}

TEST(ExposureGains, KeepTintsApartFromExposures) {
  std::vector<std::array<double, 3>> all(6, {1, 1, 1});
  all[3] = {1.1, 1, 0.9};
  const std::vector<Gain> gains = gains_of(turning_cameras(6), all);
  EXPECT_NEAR(static_cast<double>(gains[3][0] / gains[2][0]), 1 / 1.1, 0.03);
  EXPECT_NEAR(static_cast<double>(gains[3][1] / gains[2][1]), 1, 0.03);
  EXPECT_NEAR(static_cast<double>(gains[3][2] / gains[2][2]), 1 / 0.9, 0.03);
}

TEST(ExposureGains, StayWithinTheirBoundsAndAreWholeSteps) {
  std::vector<std::array<double, 3>> all(5, {1, 1, 1});
  all[2] = {0.2, 0.2, 0.2};
  for (const Gain& gain : gains_of(turning_cameras(5), all))
    for (const float g : gain) {
      EXPECT_LE(static_cast<double>(g), exposure::kLargestGain);
      EXPECT_GE(static_cast<double>(g), 1 / exposure::kLargestGain);
      EXPECT_EQ(g * 1024, std::round(g * 1024)) << "the same on every machine";
    }
}

TEST(ExposureGains, OfPhotographsThatShareNothingAreOne) {
  std::vector<Camera> cameras{test::camera_at(0), test::camera_at(3.14)};
  for (Camera& camera : cameras) camera.pose.centre.setZero();
  for (const Gain& gain : gains_of(cameras, {{1.5, 1.5, 1.5}, {0.5, 0.5, 0.5}}))
    for (const float g : gain) EXPECT_EQ(g, 1);
}

TEST(ExposureGains, ArePhotographsOwnInAnyOrder) {
  std::vector<Camera> cameras = turning_cameras(4);
  std::vector<std::array<double, 3>> exposures{{1, 1, 1}, {1.2, 1.2, 1.2}, {0.9, 0.9, 0.9}, {1, 1, 1}};
  const std::vector<Gain> forward = gains_of(cameras, exposures);
  std::reverse(cameras.begin(), cameras.end());
  std::reverse(exposures.begin(), exposures.end());
  const std::vector<Gain> backward = gains_of(cameras, exposures);
  for (size_t i = 0; i < 4; ++i)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(forward[i][c], backward[3 - i][c], 0.02F);
}

TEST(Thumbnails, AreMeansOfBlocksAndTrustNoneThatIsClipped) {
  RgbImage photo(640, 320, {100, 50, 200});
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x) photo.at(x, y) = {static_cast<uint8_t>(x % 2 == 0 ? 80 : 120), 50, 200};
  for (int y = 20; y < 30; ++y)
    for (int x = 20; x < 22; ++x) photo.at(x, y) = {255, 255, 255};
  for (int i = 0; i < 12; ++i) photo.at(50 + i % 10, 50 + i / 10) = {0, 0, 0};
  for (int i = 0; i < 13; ++i) photo.at(70 + i % 10, 50 + i / 10) = {255, 255, 255};
  const Thumbnail thumbnail = make_thumbnail(photo);
  EXPECT_EQ(thumbnail.block_px, 10);
  EXPECT_EQ(thumbnail.mean.width, 64);
  EXPECT_EQ(thumbnail.mean.height, 32);
  EXPECT_FLOAT_EQ(thumbnail.mean.at(0, 0)[0], 100);
  EXPECT_FLOAT_EQ(thumbnail.mean.at(9, 9)[2], 200);
  EXPECT_TRUE(thumbnail.usable.at(0, 0));
  EXPECT_FALSE(thumbnail.usable.at(2, 2)) << "a fifth of it is white";
  EXPECT_TRUE(thumbnail.usable.at(5, 5)) << "an eighth of its pixels may be clipped";
  EXPECT_FALSE(thumbnail.usable.at(7, 5));
  EXPECT_EQ(make_thumbnail(RgbImage(3, 2, {9, 9, 9})).block_px, 1);
}

TEST(LeftOutWords, NameEveryCauseOnceAndTheFiguresThatBelongToIt) {
  LeftOut why;
  EXPECT_EQ(words_of(why), "");
  EXPECT_FALSE(why);
  why.original = "IMG_7.jpg", why.inliers = 5;
  std::set<std::string> told;
  for (int cause = 1; cause <= static_cast<int>(LeftOutCause::no_camera); ++cause) {
    why.cause = static_cast<LeftOutCause>(cause);
    EXPECT_TRUE(why);
    EXPECT_NE(words_of(why), "") << cause;
    EXPECT_TRUE(told.insert(words_of(why)).second) << words_of(why);
  }
  why.cause = LeftOutCause::other_size;
  EXPECT_EQ(words_of(why), "its size is not that of most photos (turned, cropped or scaled?)");
  why.cause = LeftOutCause::repeated;
  EXPECT_EQ(words_of(why), "it is the same picture as IMG_7.jpg");
  why.cause = LeftOutCause::needless;
  EXPECT_EQ(words_of(why), "it shows next to nothing that IMG_7.jpg does not");
  why.cause = LeftOutCause::few_inliers;
  EXPECT_THAT(words_of(why), HasSubstr("only 5 of its points"));
}

}  // namespace
}  // namespace ldp
