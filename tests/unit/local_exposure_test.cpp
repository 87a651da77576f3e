// Photographs of automatic exposure: the camera's response, the light of each, and what a panorama shows of them.
#include "core/photos/exposure/local_exposure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/colour/photo_sampler.h"
#include "core/panorama/even_exposure.h"
#include "core/photos/exposure/calibration.h"
#include "core/photos/exposure/photo_exposure.h"
#include "core/rectify/rectify.h"
#include "tests/golden/synthetic_panorama.h"
#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

// Of a camera with contrast: the level of so much light, 1 being nearly white.
double level_of_light(double light) { return 255 * (1 - std::exp(-2.2 * std::pow(light, 0.7))); }

// Light of 0.02 to 0.5 by direction, in shade on one side.
double light_in(const Eigen::Vector3d& d, size_t channel) {
  const double theta = std::atan2(d.y(), d.x());
  const double texture =
      0.6 + 0.4 * std::sin(11 * theta + 7 * d.z() / d.head<2>().norm() + static_cast<double>(channel));
  return texture * (0.06 + 0.5 * std::pow(0.5 + 0.5 * std::sin(theta), 2));
}

RgbImage photo_of(const Camera& camera, double exposure) {
  RgbImage photo(camera.intrinsics.width, camera.intrinsics.height);
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      const Eigen::Vector3d d =
          camera.pose.world_from_camera * unproject(camera.intrinsics, Eigen::Vector2d(x + 0.5, y + 0.5));
      const auto level = [&](size_t c) {
        return static_cast<uint8_t>(std::lround(level_of_light(exposure * light_in(d, c))));
      };
      photo.at(x, y) = {level(0), level(1), level(2)};
    }
  return photo;
}

// A full turn on the spot, and exposures that follow the light.
struct Turn {
  std::vector<Camera> cameras;
  std::vector<double> exposures;
  std::vector<RgbImage> photos;
  std::vector<int> indices;

  explicit Turn(bool automatic) {
    constexpr int kPhotos = 12;
    for (int i = 0; i < kPhotos; ++i) {
      const double theta = 2 * std::numbers::pi * i / kPhotos;
      cameras.push_back(test::camera_at(theta));
      cameras.back().pose.centre.setZero();
      exposures.push_back(automatic ? 0.12 / (0.06 + 0.5 * std::pow(0.5 + 0.5 * std::sin(theta), 2)) : 1);
      photos.push_back(photo_of(cameras.back(), exposures.back()));
      indices.push_back(i);
    }
  }

  std::vector<Thumbnail> thumbnails() const {
    std::vector<Thumbnail> all;
    for (const RgbImage& photo : photos) all.push_back(make_thumbnail(photo));
    return all;
  }
  Calibration calibrated() const { return calibrate(exposure::overlaps(cameras, thumbnails(), {}), cameras.size()); }
};

ResponseCurve square_response() {
  ResponseCurve response;
  for (uint32_t i = 0; i < ResponseCurve::kKnots; ++i) response.light[i] = 1000 * i * i;
  return response;
}

TEST(ResponseCurve, GoesFromLevelsToLightAndBack) {
  const ResponseCurve response = square_response();
  EXPECT_EQ(response.light_of(0), 0);
  EXPECT_EQ(response.light_of(16), 1000);
  EXPECT_EQ(response.light_of(24), 2500);
  for (int level = 0; level < 256; ++level) EXPECT_NEAR(response.level_of(response.light_of(level)), level, 1e-9);
  EXPECT_EQ(response.level_of(1e9), 256);
}

TEST(ResponseCurve, GivesMoreLightLessAndLeavesBlackAndWhiteAsTheyAre) {
  const ResponseCurve response = square_response();
  EXPECT_EQ(with_light({64, 32, 0}, 1, {4, 4, 4}, response), (std::array{128, 64, 0}));
  EXPECT_EQ(with_light({128, 64, 0}, 1, {0.25, 1, 1}, response), (std::array{64, 64, 0}));
  EXPECT_EQ(with_light({200, 100, 50}, 1, {9, 1, 1}, response), (std::array{255, 100, 50}));
  EXPECT_EQ(with_light({255, 255, 255}, 1, {0.1, 0.2, 0.3}, response), (std::array{255, 255, 255})) << "clipped";
  EXPECT_EQ(with_light({255, 180, 90}, 1, {0.1, 0.1, 0.1}, response), (std::array{255, 180, 90}));
  EXPECT_LT(with_light({240, 240, 240}, 1, {0.25, 0.25, 0.25}, response)[0], 160) << "half way to white";
  for (int level = 0; level < 256; ++level)
    EXPECT_EQ(with_light({16 * level, 0, 0}, 16, {1, 1, 1}, response)[0], 16 * level);
}

TEST(Calibration, BringsPhotographsOfALightAndAShadeTogether) {
  const Turn turn(true);
  const Calibration calibration = turn.calibrated();
  double most = 0, least = 1e9;
  for (size_t i = 0; i < turn.cameras.size(); ++i) {
    most = std::max(most, static_cast<double>(calibration.light_gains[i][1]));
    least = std::min(least, static_cast<double>(calibration.light_gains[i][1]));
  }
  EXPECT_GT(most / least, 4) << "exposures lie far apart";
  // One exposure for all: what neighbours show of one direction is one level.
  for (size_t i = 0; i < turn.cameras.size(); ++i) {
    const size_t j = (i + 1) % turn.cameras.size();
    const double middle = 2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / 12;
    for (const double aside : {-0.1, 0.0, 0.1}) {
      const Eigen::Vector3d d{std::cos(middle + aside), std::sin(middle + aside), 0.1};
      std::array<int, 2> evened{};
      bool clipped = false;
      for (const size_t k : {size_t{0}, size_t{1}}) {
        const size_t photo = k == 0 ? i : j;
        const int level = static_cast<int>(std::lround(16 * level_of_light(turn.exposures[photo] * light_in(d, 1))));
        clipped |= level > 16 * 230;
        const Gain& gain = calibration.light_gains[photo];
        evened[k] = with_light({level, level, level}, 16, {gain[0], gain[1], gain[2]}, calibration.response)[1];
        clipped |= evened[k] > 16 * 230;
      }
      if (clipped) continue;
      EXPECT_NEAR(evened[0] / 16.0, evened[1] / 16.0, 0.05 * evened[0] / 16 + 1) << i << " " << aside;
    }
  }
}

TEST(LocalExposure, IsWantedWhereExposuresLieApartAlone) {
  const Turn turn(true);
  std::vector<Gain> gains(turn.cameras.size(), {1, 1, 1});
  EXPECT_FALSE(LocalExposure(turn.cameras, gains).is_wanted());
  for (size_t i = 0; i < gains.size(); ++i)
    gains[i] = i % 2 == 0 ? Gain{1.3F, 1.3F, 1.3F} : Gain{1 / 1.3F, 1 / 1.3F, 1 / 1.3F};
  EXPECT_FALSE(LocalExposure(turn.cameras, gains).is_wanted()) << "every direction is as bright as its photographs";
  for (size_t i = 0; i < gains.size(); ++i) gains[i] = i < 6 ? Gain{1, 1, 1.5F} : Gain{1, 1, 0.7F};
  EXPECT_TRUE(LocalExposure(turn.cameras, gains).is_wanted()) << "in one channel";
}

TEST(LocalExposure, OfAPanoramaIsSmoothAndGoesRoundWithoutASeam) {
  const Turn turn(true);
  std::vector<Gain> gains;
  for (const double exposure : turn.exposures)
    gains.push_back(Gain{1, 1, 1}), gains.back().fill(static_cast<float>(1 / exposure));
  PanoramaGrid grid = test::simple_grid(0.5);
  grid.width = 628, grid.theta_pitch = 2 * std::numbers::pi / grid.width, grid.wraps = true;
  const GainField field = LocalExposure(turn.cameras, gains).over(grid);
  EXPECT_TRUE(field.wraps);
  double before = field.at(1 - 0.5 / 628, 0.5)[1], most = 0, least = 1e9;
  for (int x = 0; x < 628; ++x) {
    const double here = field.at((x + 0.5) / 628, 0.5)[1];
    EXPECT_NEAR(here / before, 1, 0.03) << x;
    most = std::max(most, here), least = std::min(least, here);
    before = here;
  }
  EXPECT_GT(most / least, 3);
  for (size_t i = 0; i < gains.size(); ++i) {  // in the middle of a photograph about as bright as it is
    const double theta = 2 * std::numbers::pi * static_cast<double>(i) / 12;
    double share = (grid.theta_left - theta) / (2 * std::numbers::pi);
    share -= std::floor(share);
    EXPECT_NEAR(field.at(share, 0.5)[1] / turn.exposures[i], 1, 0.2) << i;
  }
}

TEST(LocalExposure, OfOnePhotographAloneLeavesItAsItIs) {
  const std::vector<Camera> one{test::camera_at(0.3)};
  const GainField field = LocalExposure(one, {Gain{0.25F, 2, 1}}).over_photo(0);
  for (const double at : {0.0, 0.4, 1.0})
    for (const double factor : field.at(at, at)) EXPECT_NEAR(factor, 1, 1e-3);
}

TEST(LocalExposure, OfAViewIsTakenBackToThatOfAPhotograph) {
  const std::vector<Camera> cameras{test::camera_at(0), test::camera_at(0.4), test::camera_at(0.9)};
  const std::vector<Gain> gains{{0.5F, 2, 1}, {1, 1, 1.5F}, {3, 0.7F, 1}};
  const LocalExposure local(cameras, gains);
  for (size_t i = 0; i < cameras.size(); ++i) {
    const GainField there = local.over_photo(i);
    const GainField back = local.back_to_photo(cameras[i], gains[i]);
    for (const double at : {0.1, 0.6, 0.9})
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(there.at(at, 0.5)[c] * back.at(at, 0.5)[c], 1, 0.01);
  }
  const GainField brighter = local.back_to_photo(cameras[1], {0.5F, 0.5F, 0.75F});
  for (size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(brighter.at(0.3, 0.3)[c] / local.back_to_photo(cameras[1], gains[1]).at(0.3, 0.3)[c], 2, 0.01);
}

TEST(LocalExposureOfPhotos, SamplesAutomaticExposuresAtThatOfTheirDirection) {
  const Turn turn(true);
  std::optional<Calibration> calibration;
  const auto frames =
      rectify(test::FramesInMemory(turn.photos), turn.cameras, turn.indices, {}, Arc(), 1, {}, &calibration);
  ASSERT_TRUE(calibration);
  // Middles of photographs keep their contrast: neither the darkest nor the brightest has less than half of the mean.
  std::vector<double> contrasts;
  for (const UprightFrame& frame : frames) {
    double sum = 0;
    for (int x = 40; x < 100; ++x) sum += std::abs(frame.columns.at(40, x) - frame.columns.at(40, x - 6));
    contrasts.push_back(sum);
  }
  double mean = 0;
  for (const double c : contrasts) mean += c / static_cast<double>(contrasts.size());
  for (const double c : contrasts) EXPECT_GT(c, 0.5 * mean);
  const Turn fixed(false);
  rectify(test::FramesInMemory(fixed.photos), fixed.cameras, fixed.indices, {}, Arc(), 1, {}, &calibration);
  EXPECT_FALSE(calibration) << "one exposure for all does";
}

TEST(PhotoSampler, TakesLightByGainAndDirection) {
  const PanoramaGrid grid = test::simple_grid(0.5);
  DisplayExposure local;
  local.response = square_response();
  local.factors.nodes = {1, 1};
  local.factors.nodes.at(0, 0) = {2048, 4096, 8192};
  const RgbImage photo(140, 80, {64, 64, 64});
  const colour::PhotoSampler sampler(grid, test::camera_at(0), {2, 4, 2}, &local);
  const colour::Colour c = sampler.sample(photo, 50, 30, 0.2);
  EXPECT_EQ(c, (colour::Colour{16 * 64, 16 * 128, 16 * 128})) << "of 1, 4 and 4 times the light";
}

TEST(EvenExposure, TakesTheFactorsOutOfAllLayers) {
  SyntheticOptions options;
  LayeredPanorama panorama = synthetic_panorama(options);
  const LayeredPanorama before = panorama;
  even_out(panorama);
  EXPECT_EQ(panorama.layers, before.layers) << "even already";
  panorama.exposure.response = square_response();
  panorama.exposure.factors.nodes = {1, 1};
  panorama.exposure.factors.nodes.at(0, 0) = {4 * 4096, 4096, 1024};
  panorama.layers[0].colour.at(50, 20) = {128, 100, 64};
  panorama.layers[1].colour.at(50, 20) = {64, 100, 32};
  even_out(panorama);
  EXPECT_TRUE(panorama.exposure.empty());
  EXPECT_EQ(panorama.layers[0].colour.at(50, 20), (Rgb{64, 100, 128}));
  EXPECT_EQ(panorama.layers[1].colour.at(50, 20), (Rgb{32, 100, 64}));
}

}  // namespace
}  // namespace ldp
