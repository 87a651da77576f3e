#include "core/consistency/consistency.h"
#include "core/consistency/back_projection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/view/render.h"
#include "core/view/strip_renderer.h"

namespace ldp {
namespace {

constexpr double kFar = 0.5, kNear = 1.5;  // inverse depths

PanoramaGrid make_grid() {
  PanoramaGrid grid;
  grid.arc.radius = 0.6;
  grid.width = 512;
  grid.height = 160;
  grid.theta_left = 1.28;
  grid.theta_pitch = grid.v_pitch = 0.005;
  grid.v_top = 0.4;
  grid.w_near = 2;
  return grid;
}

// Looks outwards from the arc at theta, turned aside by `turned`.
Camera make_camera(const PanoramaGrid& grid, double theta, double turned = 0) {
  Camera camera;
  camera.name = std::to_string(theta);
  camera.intrinsics = {120, 90, 150, 150, 60, 45};
  const Eigen::Vector3d forward = grid.arc.outward(theta + turned), up = grid.arc.axis();
  camera.pose.world_from_camera << forward.cross(up), -up, forward;
  camera.pose.centre = grid.arc.centre + grid.arc.radius * grid.arc.outward(theta);
  return camera;
}

Rgb texture(int x, int y) {
  const auto wave = [](double phase) { return static_cast<uint8_t>(std::lround(120 + 60 * std::sin(phase))); };
  return {wave(0.31 * x + 0.2 * y), wave(0.17 * x - 0.4 * y), wave(0.4 * y + 0.23 * x)};
}

// A wall, and a red post before it in columns [250, 262) where it is wanted.
LayeredPanorama make_panorama(bool post) {
  const PanoramaGrid grid = make_grid();
  LayeredPanorama panorama{grid, {}, {}, {}, {}, {}};
  for (const bool behind : {false, true}) {
    Layer layer;
    DisparityMap disparity(grid.width, grid.height, kNoDisparity);
    layer.coverage = Plane<uint8_t>(grid.width, grid.height);
    layer.colour = RgbImage(grid.width, grid.height);
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x) {
        const bool in_post = post && x >= 250 && x < 262;
        if (behind && !in_post) continue;
        const double w = in_post && !behind ? kNear : kFar;
        disparity.at(x, y) = static_cast<uint16_t>(std::lround(w / grid.w_near * kDisparitySteps));
        layer.coverage.at(x, y) = 1;
        layer.colour.at(x, y) = in_post && !behind ? Rgb{200, uint8_t(20 + y % 40), 30} : texture(x, y);
      }
    layer.depth = encode_depth(disparity, 16);
    panorama.layers.push_back(std::move(layer));
  }
  for (int i = 0; i < 6; ++i) panorama.cameras.push_back(make_camera(grid, 0.45 - 0.18 * i));
  return panorama;
}

struct Pictures : FrameSource {
  std::vector<RgbImage> pictures;

  // What a panorama's cameras see of it, surface by surface.
  explicit Pictures(const LayeredPanorama& panorama) {
    const Renderer renderer(panorama);
    for (const Camera& camera : panorama.cameras)
      pictures.push_back(renderer.render(camera, {.outlines = false}).colour);
  }
  int size() const override { return static_cast<int>(pictures.size()); }
  std::string name(int index) const override { return std::to_string(index); }
  RgbImage load(int index) const override { return pictures.at(static_cast<size_t>(index)); }
  std::optional<double> focal_hint(int) const override { return {}; }
};

ConsistencyReport held(const Pictures& photos, const LayeredPanorama& panorama, int threads = 1,
                       const Gain& gain = {1, 1, 1}, const std::vector<consistency::Observer*>& observers = {}) {
  std::vector<int> frames;
  for (int i = 0; i < photos.size(); ++i) frames.push_back(i);
  const std::vector<Gain> gains(frames.size(), gain);
  Job job;
  job.threads = threads;
  return hold_against({photos, frames, gains}, panorama, {}, job, {}, observers);
}

TEST(Consistency, APanoramaAgreesWithItsOwnRenderings) {
  const LayeredPanorama panorama = make_panorama(true);
  const ConsistencyReport report = held(Pictures(panorama), panorama);
  ASSERT_EQ(report.photos.size(), 6U);
  EXPECT_GT(report.all.psnr_db(), 60);
  EXPECT_EQ(report.all.pixels, 6 * 120 * 90);
  EXPECT_DOUBLE_EQ(report.all.share(Agreement::agrees), 1);
  EXPECT_DOUBLE_EQ(report.all.unexplained_share(), 0);
  EXPECT_NEAR(report.photos[2].sharpness, 1, 1e-3);
}

TEST(Consistency, APostThatThePanoramaLacksIsMissing) {
  const ConsistencyReport report = held(Pictures(make_panorama(true)), make_panorama(false));
  EXPECT_GT(report.all.share(Agreement::missing), 0.03);
  EXPECT_GT(report.all.share(Agreement::missing), 3 * report.all.share(Agreement::wrong_depth));
  EXPECT_GT(report.all.share(Agreement::missing), 3 * report.all.share(Agreement::wrong_colour));
}

TEST(Consistency, APostThatIsNotThereIsAWrongDepth) {
  const ConsistencyReport report = held(Pictures(make_panorama(false)), make_panorama(true));
  EXPECT_GT(report.all.share(Agreement::wrong_depth), 0.03);
  EXPECT_GT(report.all.share(Agreement::wrong_depth), 3 * report.all.share(Agreement::missing));
}

TEST(Consistency, PaintOnASurfaceIsAWrongColour) {
  LayeredPanorama painted = make_panorama(false);
  for (int y = 60; y < 100; ++y)
    for (int x = 200; x < 300; ++x) painted.layers[0].colour.at(x, y) = {255, 255, 0};
  const ConsistencyReport report = held(Pictures(make_panorama(false)), painted);
  EXPECT_GT(report.all.share(Agreement::wrong_colour), 0.03);
  EXPECT_LT(report.all.share(Agreement::missing) + report.all.share(Agreement::wrong_depth), 0.01);
  EXPECT_NEAR(report.all.unexplained_share(), report.all.share(Agreement::wrong_colour), 0.01);
}

TEST(Consistency, PhotosAreComparedAtEvenExposure) {
  const LayeredPanorama panorama = make_panorama(false);
  Pictures dark(panorama);
  for (RgbImage& picture : dark.pictures)
    for (Rgb& c : picture.samples) c = {uint8_t(c.r / 2), uint8_t(c.g / 2), uint8_t(c.b / 2)};
  EXPECT_GT(held(dark, panorama, 1, {2, 2, 2}).all.psnr_db(), 45);
  EXPECT_LT(held(dark, panorama).all.psnr_db(), 15);
}

TEST(Consistency, ABrightnessThatMostOfAPlaceSharesIsExposure) {
  const LayeredPanorama panorama = make_panorama(false);
  Pictures photos(panorama);
  for (RgbImage& picture : photos.pictures)
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        Rgb& c = picture.at(x, y);
        const int more = x / 10 % 3 == 0 ? -50 : 50;  // two thirds are brighter
        c = {static_cast<uint8_t>(c.r + more), static_cast<uint8_t>(c.g + more), static_cast<uint8_t>(c.b + more)};
      }
  const ConsistencyReport report = held(photos, panorama);
  EXPECT_NEAR(report.all.share(Agreement::exposure), 2.0 / 3, 0.1);
  EXPECT_LT(report.all.share(Agreement::agrees), 0.1);
}

TEST(Consistency, AWrongPoseIsAShiftOfItsPhoto) {
  const LayeredPanorama panorama = make_panorama(false);
  Pictures photos(panorama);
  LayeredPanorama turned = panorama;
  turned.cameras[3] = make_camera(panorama.grid, 0.45 - 0.18 * 3, 0.3 / 150);  // to the left by 0.3 px
  const ConsistencyReport report = held(photos, turned);
  EXPECT_NEAR(report.photos[3].shift_x, -0.3, 0.06);
  EXPECT_NEAR(report.photos[3].shift_y, 0, 0.02);
  EXPECT_NEAR(report.photos[1].shift_x, 0, 0.02);
}

TEST(Consistency, ResidualsStandInTheDirectionWhereTheyAre) {
  const ConsistencyReport report = held(Pictures(make_panorama(true)), make_panorama(false));
  const PanoramaGrid grid = make_grid();
  const double post = grid.theta(256);
  int64_t all = 0;
  double worst = 99, worst_at = 0;
  for (const DirectionResiduals& d : report.directions) {
    EXPECT_LT(d.from, d.to);
    all += d.statistics.pixels;
    if (d.statistics.pixels > 0 && d.statistics.psnr_db() < worst)
      worst = d.statistics.psnr_db(), worst_at = (d.from + d.to) / 2;
  }
  EXPECT_EQ(all, report.all.pixels);
  EXPECT_NEAR(worst_at, post, 0.25);
}

TEST(Consistency, ThreadsDoNotMatter) {
  const Pictures photos(make_panorama(true));
  const LayeredPanorama panorama = make_panorama(false);
  const ConsistencyReport one = held(photos, panorama, 1), four = held(photos, panorama, 4);
  EXPECT_EQ(one.all.classes, four.all.classes);
  EXPECT_EQ(one.all.squared_difference, four.all.squared_difference);
}

TEST(Consistency, StripsShowTheSameAsTheWholePanorama) {
  for (const bool wraps : {false, true}) {
    LayeredPanorama panorama = make_panorama(true);
    if (wraps) {
      panorama.grid.wraps = true;
      panorama.grid.theta_pitch = 2 * 3.14159265358979 / panorama.grid.width;
      for (int i = 0; i < 6; ++i)
        panorama.cameras[static_cast<size_t>(i)] = make_camera(panorama.grid, 1.28 + 0.3 - 0.12 * i);
    }
    const std::vector<Camera> cameras =
        std::exchange(panorama.cameras, {});  // so that nothing is made up beyond frames
    const Renderer whole(panorama);
    StripRenderer strips(panorama);
    for (const Camera& camera : cameras) {
      const View a = whole.render(camera, {}), b = strips.render(camera, {}, {});
      int64_t differing = 0;
      for (size_t i = 0; i < a.colour.samples.size(); ++i)
        for (const int d : {a.colour.samples[i].r - b.colour.samples[i].r, a.alpha.samples[i] - b.alpha.samples[i]})
          differing += std::abs(d) > 1;
      EXPECT_EQ(differing, 0) << camera.name << (wraps ? ", wraps" : "");
    }
  }
}

LayeredPanorama drawn_to(const Pictures& photos, LayeredPanorama panorama, int threads = 1) {
  Job job;
  job.threads = threads;
  BackProjection towards(panorama, job);
  held(photos, panorama, threads, {1, 1, 1}, {&towards});
  towards.correct(panorama.layers.front());
  return panorama;
}

// The front layer's colours, each the mean of nine.
LayeredPanorama blurred(LayeredPanorama panorama) {
  RgbImage& colour = panorama.layers[0].colour;
  const RgbImage sharp = colour;
  for (int y = 1; y + 1 < colour.height; ++y)
    for (int x = 1; x + 1 < colour.width; ++x) {
      std::array<int, 3> sum{};
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
          const Rgb c = sharp.at(x + i, y + j);
          sum[0] += c.r, sum[1] += c.g, sum[2] += c.b;
        }
      colour.at(x, y) = {uint8_t(sum[0] / 9), uint8_t(sum[1] / 9), uint8_t(sum[2] / 9)};
    }
  return panorama;
}

int grey(Rgb c) { return (77 * c.r + 150 * c.g + 29 * c.b) / 256; }

// In grey, where photographs from all sides see the wall.
double mean_difference(const LayeredPanorama& a, const LayeredPanorama& b) {
  int64_t sum = 0, count = 0;
  for (int y = 50; y < 110; ++y)
    for (int x = 180; x < 330; ++x, ++count)
      sum += std::abs(grey(a.layers[0].colour.at(x, y)) - grey(b.layers[0].colour.at(x, y)));
  return static_cast<double>(sum) / static_cast<double>(count);
}

TEST(BackProjection, WhatIsBlurredComesCloserToThePhotographs) {
  LayeredPanorama truth = make_panorama(false);
  for (Rgb& c : truth.layers[0].colour.samples) c.r = c.b = c.g;
  const Pictures photos(truth);
  const LayeredPanorama before = blurred(truth), after = drawn_to(photos, before);
  EXPECT_LT(mean_difference(after, truth), 0.5 * mean_difference(before, truth));
  EXPECT_GT(held(photos, after).all.psnr_db(), held(photos, before).all.psnr_db() + 3);
}

TEST(BackProjection, WhatIsRightStays) {
  const LayeredPanorama truth = make_panorama(true);
  EXPECT_LT(mean_difference(drawn_to(Pictures(truth), truth), truth), 0.1);
}

TEST(BackProjection, AnotherThingThatPhotographsShowIsLeftToIt) {
  const LayeredPanorama without = make_panorama(false);
  EXPECT_LT(mean_difference(drawn_to(Pictures(make_panorama(true)), without), without), 0.5);
}

TEST(BackProjection, PhotographsThatDisagreeMoveNothing) {
  const LayeredPanorama panorama = make_panorama(false);
  Pictures photos(panorama);
  for (size_t i = 0; i < photos.pictures.size(); ++i)
    for (Rgb& c : photos.pictures[i].samples) {
      const int by = i % 2 == 0 ? 20 : -20;
      c = {uint8_t(c.r + by), uint8_t(c.g + by), uint8_t(c.b + by)};
    }
  EXPECT_LT(mean_difference(drawn_to(photos, panorama), panorama), 3);
}

TEST(BackProjection, ThreadsDoNotMatter) {
  const LayeredPanorama truth = make_panorama(true), before = blurred(truth);
  const Pictures photos(truth);
  EXPECT_EQ(drawn_to(photos, before, 1).layers, drawn_to(photos, before, 4).layers);
}

}  // namespace
}  // namespace ldp
