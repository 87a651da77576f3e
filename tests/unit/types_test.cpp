#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "core/base/job.h"
#include "core/base/scratch_pool.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/geometry/same_surface.h"
#include "core/geometry/voxel_projection.h"
#include "core/photos/catmull_rom.h"
#include "core/photos/exposure_gain.h"

namespace ldp {
namespace {

PanoramaGrid some_grid() {
  PanoramaGrid grid;
  grid.arc.centre = {1, 2, 3};
  grid.arc.radius = 0.65;
  grid.width = 2000;
  grid.height = 700;
  grid.theta_left = 2.5;
  grid.theta_pitch = grid.v_pitch = 1 / 700.0;
  grid.v_top = 0.5;
  grid.w_far = 0;
  grid.w_near = 1;
  return grid;
}

TEST(Geometry, UnprojectInvertsProject) {
  const Intrinsics k{800, 600, 700, 705, 401, 299, -0.1, 0.02, 0.001, -0.002};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at_x(0, 800), at_y(0, 600);
  for (int i = 0; i < 1000; ++i) {
    const double x = at_x(random);
    const double y = at_y(random);
    const Eigen::Vector2d there = project(k, 3.0 * unproject(k, {x, y}));
    EXPECT_NEAR(there.x(), x, 1e-5);
    EXPECT_NEAR(there.y(), y, 1e-5);
  }
}

// The polynomial of a real lens turns back somewhere outside the picture.
TEST(Geometry, WhatLiesFartherOutIsProjectedFartherOut) {
  for (const auto& [k1, k2] : {std::pair{-0.25, 0.0}, {0.21, -0.30}, {-0.6, 0.15}, {-0.1, -0.1}, {-0.3, 0.2}}) {
    const Intrinsics k{800, 600, 700, 700, 400, 300, k1, k2};
    bool turns_back = false;
    Eigen::Vector2d before(0, 0), bent_before(0, 0);
    for (int step = 1; step < 1000; ++step) {
      const Eigen::Vector2d n(0.006 * step, 0.008 * step), bent = distort(k, n);
      EXPECT_GT(bent.norm(), bent_before.norm()) << k1 << ' ' << k2 << ", at " << n.norm();
      EXPECT_NEAR(bent.x() * n.y(), bent.y() * n.x(), 1e-9 * n.squaredNorm());
      const Eigen::Vector2d polynomial = distort_by_polynomial(k, n);
      turns_back |= polynomial.norm() <= distort_by_polynomial(k, before).norm();
      if (leads_outward(k, n.squaredNorm())) {
        EXPECT_EQ(bent, polynomial);
      } else {
        EXPECT_LT((bent - bent_before).norm(), 1.01 * (n - before).norm()) << "without a jump, at " << n.norm();
      }
      before = n, bent_before = bent;
    }
    EXPECT_EQ(turns_back, k2 < 0.2) << k1 << ' ' << k2;
  }
}

TEST(Geometry, LocateInvertsPointForBothKindsOfRays) {
  PanoramaGrid grid = some_grid();
  for (const Rays rays : {Rays::pushbroom, Rays::central}) {
    grid.rays = rays;
    for (double x = 10.5; x < 2000; x += 100) {
      const double y = x / 3;
      const PanoramaPosition back = locate(grid, grid.point(grid.theta(x), grid.v(y), 0.4));
      EXPECT_NEAR(back.x_px, x, 1e-9);
      EXPECT_NEAR(back.y_px, y, 1e-9);
      EXPECT_NEAR(back.inverse_depth, 0.4, 1e-12);
    }
  }
}

TEST(Geometry, AnglesGrowAnticlockwiseSeenFromAbove) {
  const Arc arc;
  EXPECT_NEAR((arc.outward(std::numbers::pi / 2) - Eigen::Vector3d(0, 1, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((arc.axis() - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
}

TEST(VoxelProjection, PutsAVoxelWhereItsPointIs) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Rays rays : {Rays::pushbroom, Rays::central}) {
    PanoramaGrid grid;
    grid.rays = rays;
    grid.arc.radius = 0.6;
    grid.arc.centre = {0.1, -0.2, 0.3};
    grid.arc.world_from_arc.col(0) = Eigen::Vector3d(0, 1, 0);
    grid.arc.world_from_arc.col(1) = Eigen::Vector3d(0, 0, 1);
    grid.arc.world_from_arc.col(2) = Eigen::Vector3d(1, 0, 0);
    Camera camera;
    camera.intrinsics = {640, 480, 500, 510, 320, 240, 0.02, -0.01, 0.001, 0.002};
    camera.pose.centre = {0.2, 0.4, 0.1};
    camera.pose.world_from_camera.col(2) = grid.arc.outward(0.4);
    camera.pose.world_from_camera.col(1) = -grid.arc.axis();
    camera.pose.world_from_camera.col(0) = camera.pose.world_from_camera.col(1).cross(grid.arc.outward(0.4));
    const UprightCamera upright{
        camera.pose.centre, camera.pose.world_from_camera.col(0), grid.arc.outward(0.4), 500, 320, 240, 640, 480, 0};
    const PhotoProjection into_photo(grid, camera);
    const VoxelProjection into_upright(grid, upright);
    for (int i = 0; i < 50; ++i) {
      const double theta = 0.4 + 0.3 * uniform(random), v = 0.3 * uniform(random), w = 0.3 + 0.2 * uniform(random);
      const Eigen::Vector3d q =
          camera.pose.world_from_camera.transpose() * (grid.point(theta, v, w) - camera.pose.centre);
      const Eigen::Vector3d times_w = into_photo.in_camera_axes(heading(theta), v, w);
      ASSERT_LT((times_w - w * q).norm(), 1e-8);
      const VoxelProjection::Column u = into_upright.column(heading(theta));
      const double forward = into_upright.forward(u, w);
      ASSERT_NEAR(forward, w * q.z(), 1e-8);
      ASSERT_NEAR(into_upright.x_px(u, w), 500 * q.x() / q.z() + 320, 1e-5);
      ASSERT_NEAR(into_upright.row_offset(w, forward) + v * into_upright.row_slope(forward), 500 * q.y() / q.z() + 240,
                  1e-5);
    }
  }
}

TEST(SurfaceTolerance, GrowsWithRoundingAndWithTheNearerDepth) {
  const SurfaceTolerance<int> label{254};
  EXPECT_TRUE(label.same_surface(1000, 1254));
  EXPECT_TRUE(label.same_surface(1254, 1000));
  EXPECT_FALSE(label.same_surface(1000, 1255));
  EXPECT_TRUE(label.same_surface(1000, 1255, 1));
  const SurfaceTolerance<double> slanted{10, 0.02, 1000};  // inverse depth = 1000 + disparity
  EXPECT_TRUE(slanted.same_surface(1000, 1050));           // 10 + 0.02 * 2050 = 51
  EXPECT_FALSE(slanted.same_surface(1000, 1052));
  EXPECT_FALSE(slanted.same_surface(0, 32));  // 10 + 0.02 * 1032 = 30.6
}

TEST(CatmullRom, HitsSamplesSumsToOneAndReproducesParabolas) {
  constexpr int kPositions = 64;
  constexpr int64_t kWhole = catmull_rom_whole(kPositions);
  EXPECT_EQ(catmull_rom(0, kPositions), (std::array<int64_t, 4>{0, kWhole, 0, 0}));
  for (int64_t t = 0; t < kPositions; ++t) {
    const std::array<int64_t, 4> w = catmull_rom(t, kPositions);
    ASSERT_EQ(w[0] + w[1] + w[2] + w[3], kWhole);
    ASSERT_EQ(-w[0] + w[2] + 2 * w[3], kWhole / kPositions * t);                    // of f(x) = x
    ASSERT_EQ((w[0] + w[2] + 4 * w[3]), kWhole / kPositions / kPositions * t * t);  // of f(x) = x x
  }
}

TEST(ScratchPool, GivesBackWhatWasGivenAndMakesNoMoreThanAreOut) {
  struct Buffer {
    std::array<char, 8> room{};
    size_t bytes() const { return room.size(); }
  };
  ScratchPool<Buffer> pool;
  auto a = pool.take(), b = pool.take();
  const Buffer* first = a.get();
  ASSERT_NE(first, b.get());
  EXPECT_EQ(pool.bytes(), 0u);
  pool.give_back(std::move(a));
  EXPECT_EQ(pool.bytes(), 8u);
  EXPECT_EQ(pool.take().get(), first);
}

TEST(Disparity, UniformCodesAreTheLabelsOfThePaper) {
  DisparityMap map(16, 1);
  for (int l = 0; l < 16; ++l) map.at(l, 0) = static_cast<uint16_t>(255 * l);
  const DepthCodes depth = encode_depth(map, 0);
  for (int l = 0; l < 16; ++l) {
    EXPECT_EQ(depth.codes.at(l, 0), l);
    EXPECT_EQ(depth.disparity(l, 0), 255 * l);
  }
}

TEST(Disparity, BlockCodesAreWithinHalfAStepOfTheirRange) {
  std::mt19937 random(7);
  DisparityMap map(37, 21, kNoDisparity);
  Plane<uint8_t> coverage(37, 21, 0);
  for (size_t i = 0; i < map.samples.size(); ++i) {
    if (random() % 3 == 0) continue;
    map.samples[i] = static_cast<uint16_t>(1000 + random() % 300);
    coverage.samples[i] = 1;
  }
  const DisparityMap back = decode_depth(encode_depth(map, 8), coverage);
  for (size_t i = 0; i < map.samples.size(); ++i) {
    if (!coverage.samples[i])
      EXPECT_EQ(back.samples[i], kNoDisparity);
    else
      EXPECT_LE(std::abs(back.samples[i] - map.samples[i]), (300 + 30) / 15 / 2 + 1);
  }
}

TEST(Disparity, EncodingADecodedMapAgainChangesNothing) {
  std::mt19937 random(9);
  DisparityMap map(64, 64);
  for (uint16_t& d : map.samples) d = static_cast<uint16_t>(random() % (kDisparitySteps + 1));
  const Plane<uint8_t> all(64, 64, 1);
  const DisparityMap once = decode_depth(encode_depth(map, 16), all);
  EXPECT_EQ(decode_depth(encode_depth(once, 16), all), once);
}

// A slanted plane with a step, an absent corner, and noise of +-`noise`.
DisparityMap noisy_surfaces(unsigned noise) {
  std::mt19937 random(11);
  DisparityMap map(75, 52);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const int d = (x < 33 ? 700 : 1900) + 2 * x + 3 * y + static_cast<int>(random() % (2 * noise + 1)) -
                    static_cast<int>(noise);
      map.at(x, y) = static_cast<uint16_t>(x + y < 20 ? int{kNoDisparity} : d);
    }
  return map;
}

TEST(Disparity, WithinAToleranceNoCodeIsFartherFromItsPixelThanAllowed) {
  for (const int block_px : {0, 5, 16})
    for (const int tolerance : {1, 7, 24, 100, 255}) {
      const DisparityMap map = noisy_surfaces(20);
      const DepthCodes depth = encode_depth(map, block_px, tolerance);
      for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
          const BlockRange range = depth.range(x, y);
          if (map.at(x, y) == kNoDisparity)
            EXPECT_EQ(depth.codes.at(x, y), 0);
          else
            EXPECT_LE(std::abs(depth.disparity(x, y) - map.at(x, y)), allowed_error(range.high - range.low, tolerance))
                << x << ' ' << y << " block " << block_px << " tolerance " << tolerance;
        }
    }
  EXPECT_THROW(encode_depth(noisy_surfaces(1), 8, 256), std::logic_error);
  EXPECT_THROW(encode_depth(noisy_surfaces(1), 8, -1), std::logic_error);
}

TEST(Disparity, WithinAToleranceBlocksShareTheGridOfTheirSteps) {
  const DepthCodes depth = encode_depth(noisy_surfaces(20), 16, 24);
  int steps = 0;
  for (const BlockRange& range : depth.ranges.samples) {
    const int span = range.high - range.low;
    if (span == 0 || span == 255) continue;
    EXPECT_EQ(span % 24, 0);
    EXPECT_EQ(15 * range.low % span, 0);
    ++steps;
  }
  EXPECT_GT(steps, 10);
}

int changes_along_rows(const DepthCodes& depth) {
  int count = 0;
  for (int y = 0; y < depth.codes.height; ++y)
    for (int x = 1; x < depth.codes.width; ++x) count += depth.disparity(x, y) != depth.disparity(x - 1, y);
  return count;
}

TEST(Disparity, WithinAToleranceNoiseLeavesSurfacesWholeAndSilhouettesInPlace) {
  DisparityMap map(64, 64);
  std::mt19937 random(5);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) map.at(x, y) = static_cast<uint16_t>((x < 29 ? 1190 : 1700) + random() % 21);
  const DepthCodes depth = encode_depth(map, 16, 12);
  for (int y = 0; y < 64; ++y) {
    EXPECT_GT(depth.disparity(29, y), depth.disparity(28, y) + 400);
    EXPECT_EQ(depth.disparity(10, y), 1200);
    EXPECT_EQ(depth.disparity(50, y), 1710);
  }
  EXPECT_LT(changes_along_rows(depth), 64 * 4);
  EXPECT_GT(changes_along_rows(encode_depth(map, 16)), 64 * 50);
}

TEST(Disparity, WithinAToleranceCodesOnTheBrinkFollowTheirNeighbours) {
  DisparityMap map(48, 48);
  std::mt19937 random(3);
  for (uint16_t& d : map.samples) d = static_cast<uint16_t>(255 * 7 + 118 + random() % 16);
  EXPECT_GT(changes_along_rows(encode_depth(map, 0)), 900);
  EXPECT_LT(changes_along_rows(encode_depth(map, 0, 40)), 100);
}

TEST(ParallelFor, VisitsEveryItemOnceAndRethrowsTheFirstFailure) {
  Job job;
  job.threads = 4;
  std::vector<int> visits(1000, 0);
  parallel_for(job, 1000, [&](int i) { ++visits[static_cast<size_t>(i)]; });
  EXPECT_EQ(visits, std::vector<int>(1000, 1));
  EXPECT_THROW(parallel_for(job, 10,
                            [](int i) {
                              if (i == 3) throw Impossible("no");
                            }),
               Impossible);
}

TEST(ParallelFor, StopsWhenTheJobIsStopped) {
  std::stop_source source;
  source.request_stop();
  Job job;
  job.stop = source.get_token();
  EXPECT_THROW(parallel_for(job, 10, [](int) {}), Cancelled);
}

TEST(ExposureGain, IsAFactorBelowTheShoulder) {
  const ExposureGain gain({0.5F, 1.25F, 2});
  EXPECT_EQ(gain({100, 100, 50}, 1), (std::array{50, 125, 100}));
  EXPECT_EQ(gain({1600, 1608, 800}, 16), (std::array{800, 2010, 1600}));
}

TEST(ExposureGain, LeavesWhatIsClippedAndItsHue) {
  for (const float g : {0.25F, 0.9F, 1.1F, 4.0F}) {
    const ExposureGain gain({g, 1.1F * g, 0.9F * g});
    EXPECT_EQ(gain({255, 255, 255}, 1), (std::array{255, 255, 255}));
    EXPECT_EQ(gain({100, 150, 255}, 1), (std::array{100, 150, 255}));
  }
}

TEST(ExposureGain, RisesWithoutJumpsToWhite) {
  constexpr int kUnits = 16;
  for (const float g : {0.3F, 0.8F, 1.0F, 1.3F, 3.0F}) {
    const ExposureGain gain({g, g, g});
    int before = 0;
    for (int v = 0; v <= 255 * kUnits; ++v) {
      const int to = gain({v, v, v}, kUnits)[0];
      ASSERT_GE(to, before - 1) << g << " " << v;
      ASSERT_LE(to, before + 14) << g << " " << v;
      before = to;
    }
    EXPECT_EQ(before, 255 * kUnits);
  }
}

// By hand from the curve's equations: (0.5 + 0.5 t^2) 240 with t = 16/31; 208 + 47 k t / (1 + (k - 1) t) with
// t = (2 * 160 - 208) / 302 and k = 302 / 47.
TEST(ExposureGain, BendsWhereItsEquationsDo) {
  const auto shown = [](float gain, int level) {
    return ExposureGain({gain, gain, gain})({level * 256, level * 256, level * 256}, 256)[0] / 256.0;
  };
  EXPECT_NEAR(shown(0.5F, 240), 151.97, 0.1);
  EXPECT_NEAR(shown(0.5F, 224), 112, 0.1);
  EXPECT_NEAR(shown(2, 160), 245.18, 0.1);
  EXPECT_NEAR(shown(2, 104), 208, 0.1);
}

TEST(ExposureGain, IsUndone) {
  constexpr int kUnits = 16;
  for (const Gain& g :
       std::vector<Gain>{{0.5F, 0.5F, 0.5F}, {2, 2, 2}, {0.8F, 0.75F, 0.7F}, {1.2F, 1.1F, 1.15F}, {1.05F, 0.97F, 1}}) {
    const ExposureGain gain(g);
    for (int red = 8; red <= 255; red += 13)
      for (int green = 8; green <= 255; green += 13) {
        const std::array colour{red * kUnits, green * kUnits, 100 * kUnits};
        const auto back = gain.undone(gain(colour, kUnits), kUnits);
        for (size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(back[c], colour[c], 2 * kUnits) << g[0] << " " << red << " " << green;
      }
  }
}

}  // namespace
}  // namespace ldp
