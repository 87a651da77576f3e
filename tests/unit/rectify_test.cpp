#include "core/rectify/rectify.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

// Three upright photos of fine and coarse texture.
class Rectify : public testing::Test {
 protected:
  Rectify() {
    for (int i = 0; i < 3; ++i) {
      cameras_.push_back(test::camera_at(0.2 * i));
      const Intrinsics& k = cameras_.back().intrinsics;
      RgbImage photo(k.width, k.height);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const auto level =
              static_cast<uint8_t>(128 + 50 * std::sin(0.3 * x) * std::cos(0.2 * y) + 12 * ((x + y) % 2));
          photo.at(x, y) = {level, level, static_cast<uint8_t>(255 - level)};
        }
      photos_.push_back(std::move(photo));
    }
  }

  std::vector<UprightFrame> frames(double pitch_px) const {
    return rectify(test::FramesInMemory(photos_), cameras_, {0, 1, 2}, {}, Arc(), pitch_px, {});
  }

  std::vector<Camera> cameras_;
  std::vector<RgbImage> photos_;
};

// Largest difference between samples and the means of the n x n finer ones that they stand for, away from the borders.
int largest_step(const UprightFrame& coarse, const UprightFrame& fine, int n, GreyImage UprightFrame::*plane) {
  const auto left = static_cast<int>(fine.camera.cx - n * coarse.camera.cx);
  const auto top = static_cast<int>(fine.camera.cy - n * coarse.camera.cy);
  int largest = 0;
  for (int column = 2; column + 2 < coarse.camera.width; ++column)
    for (int row = 2; row + 2 < coarse.camera.height; ++row) {
      int sum = 0;
      for (int i = 0; i < n * n; ++i) sum += (fine.*plane).at(n * row + top + i / n, n * column + left + i % n);
      largest = std::max(largest, std::abs((coarse.*plane).at(row, column) - (sum + n * n / 2) / (n * n)));
    }
  return largest;
}

TEST_F(Rectify, APhotoThatLooksStraightUpIsNamedWithWhatToDo) {
  cameras_[1].name = "b.jpg";
  cameras_[1].pose.world_from_camera << 1, 0, 0, 0, -1, 0, 0, 0, 1;
  try {
    frames(1);
    FAIL() << "rectified";
  } catch (const std::runtime_error& error) {
    const std::string what = error.what();
    EXPECT_TRUE(what.starts_with("photo 'b.jpg' looks straight up or down")) << what;
    EXPECT_NE(what.find("a turn by 90 or by 270 degrees"), std::string::npos) << what;
  }
}

TEST_F(Rectify, CamerasThatLookAlongTheAxisAreToldBefore) {
  EXPECT_FALSE(looks_straight_up_or_down(cameras_[1], Arc()));
  for (const auto& [down_deg, wanted] : {std::pair(77, false), {80, true}, {90, true}, {-80, true}}) {
    cameras_[1] = test::camera_at(0.2);
    Eigen::Matrix3d& turned = cameras_[1].pose.world_from_camera;
    turned = turned * Eigen::AngleAxisd(down_deg * 3.14159265 / 180, Eigen::Vector3d::UnitX()).toRotationMatrix();
    EXPECT_EQ(looks_straight_up_or_down(cameras_[1], Arc()), wanted) << down_deg;
  }
}

// Three times as well: only there would a single sample in the middle differ from the mean.
TEST_F(Rectify, LargerPixelsHoldTheMeansOfThoseTheyStandFor) {
  const auto fine = frames(1);
  for (const int n : {2, 3}) {
    const auto coarse = frames(n);
    for (size_t k = 0; k < fine.size(); ++k) {
      EXPECT_NEAR(coarse[k].camera.width * n, fine[k].camera.width, 2 * (n - 1));
      EXPECT_NEAR(coarse[k].camera.height * n, fine[k].camera.height, 2 * (n - 1));
      EXPECT_NEAR(coarse[k].camera.focal * n, fine[k].camera.focal, 1e-9);
      EXPECT_LE(largest_step(coarse[k], fine[k], n, &UprightFrame::columns), 1);
      EXPECT_LE(largest_step(coarse[k], fine[k], n, &UprightFrame::tint), 1);
    }
  }
}

TEST_F(Rectify, TellsBeforehandHowManyPixelsItsFramesWillHave) {
  for (const double pitch_px : {1.0, 1.3, 2.0}) {
    size_t pixels = 0;
    for (const UprightFrame& frame : frames(pitch_px)) pixels += frame.columns.samples.size();
    EXPECT_EQ(upright_pixels(cameras_, Arc(), pitch_px), pixels);
  }
}

// A camera turns along a coarse pattern with automatic exposure and white balance: neighbours overlap by a fifth.
// What each shows is rough by half, so that no link is exact.
TEST(Exposure, LargeStepsFromPhotoToPhotoAreFoundInEachChannel) {
  constexpr double kTurn = 1;
  const std::vector<Gain> shown = {{60, 62, 58},    {140, 130, 150}, {62, 60, 62},
                                   {140, 150, 135}, {50, 55, 48},    {140, 150, 148}};
  std::vector<Camera> cameras;
  std::vector<RgbImage> photos;
  std::mt19937 random(3);
  for (const Gain& levels : shown) {
    cameras.push_back(test::camera_at(kTurn * static_cast<double>(cameras.size())));
    cameras.back().pose.centre.setZero();
    RgbImage photo(cameras.back().intrinsics.width, cameras.back().intrinsics.height);
    for (int y = 0; y < photo.height; y += 4)
      for (int x = 0; x < photo.width; x += 4) {
        const float rough = 0.5F + static_cast<float>(random()) / 4294967296.0F;
        for (int i = 0; i < 16; ++i)
          photo.at(x + i % 4, y + i / 4) = {static_cast<uint8_t>(rough * levels[0]),
                                            static_cast<uint8_t>(rough * levels[1]),
                                            static_cast<uint8_t>(rough * levels[2])};
      }
    photos.push_back(std::move(photo));
  }
  const auto frames = rectify(test::FramesInMemory(photos), cameras, {0, 1, 2, 3, 4, 5}, {}, Arc(), 1, {});
  for (size_t i = 1; i < frames.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const float found = frames[i].gain[c] / frames[i - 1].gain[c];
      EXPECT_NEAR(found * shown[i][c] / shown[i - 1][c], 1, 0.15) << "photo " << i << " channel " << c;
    }
}

// A camera moves along a wall that gets darker from end to end, always with the same exposure. Photos from far apart
// look in the same direction and share no point: that one is darker there says nothing of its exposure.
TEST(Exposure, PhotosThatChainsOfPointsJoinAreNotComparedByDirection) {
  constexpr double kWallAway = 2, kStep = 0.5;
  constexpr int kPhotos = 8, kPointsEach = 20;
  const Camera first = test::camera_at(0);
  const Eigen::Vector3d right = first.pose.world_from_camera.col(0), down = first.pose.world_from_camera.col(1),
                        ahead = first.pose.world_from_camera.col(2);
  const Intrinsics& k = first.intrinsics;
  std::vector<Camera> cameras;
  std::vector<RgbImage> photos;
  for (int i = 0; i < kPhotos; ++i) {
    cameras.push_back(first);
    cameras.back().pose.centre += i * kStep * right;
    RgbImage photo(k.width, k.height);
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x) {
        const double along = i * kStep + (x + 0.5 - k.cx) / k.fx * kWallAway;
        const auto level = static_cast<uint8_t>(std::clamp(190 * std::exp(-0.3 * along) + 0.5, 30.0, 230.0));
        photo.at(x, y) = {level, level, level};
      }
    photos.push_back(std::move(photo));
  }
  std::vector<ScenePoint> points;
  for (int i = 0; i + 1 < kPhotos; ++i)  // between two photos, which both see them
    for (int j = 0; j < kPointsEach; ++j)
      points.push_back(
          {first.pose.centre + kWallAway * ahead + (i + 0.5) * kStep * right + 0.02 * (j - 10) * down, {i, i + 1}});
  const auto frames = rectify(test::FramesInMemory(photos), cameras, {0, 1, 2, 3, 4, 5, 6, 7}, points, Arc(), 1, {});
  for (const UprightFrame& frame : frames)
    for (const float gain : frame.gain) EXPECT_NEAR(gain, 1, 0.02);
}

}  // namespace
}  // namespace ldp
