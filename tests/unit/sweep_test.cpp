#include "core/sweep/cost_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/sweep/sweep_kernels.h"
#include "core/sweep/voxel_lines.h"
#include "core/sweep/weak_membrane.h"
#include "core/sweep/weighted_median.h"
#include "tests/unit/simple_capture.h"

namespace ldp::sweep {
namespace {

using test::camera_at, test::simple_grid, test::upright_of;

double texture(double theta, double height) {
  return 128 + 30 * std::sin(90 * theta + 11 * height) + 25 * std::sin(61 * height - 37 * theta) +
         20 * std::sin(140 * theta * height + 3);
}

// What an upright camera on the circle of radius 1 sees of a textured cylinder around it, at distance 1 / w.
UprightFrame picture_of_cylinder(double theta, double w, int source, double (*paint)(double, double) = texture) {
  UprightFrame frame = upright_of(camera_at(theta), source);
  const UprightCamera& camera = frame.camera;
  const double radius = 1 + 1 / w;
  for (int x = 0; x < camera.width; ++x)
    for (int y = 0; y < camera.height; ++y) {
      const Eigen::Vector3d ray = camera.forward + (x + 0.5 - camera.cx) / camera.focal * camera.right +
                                  (camera.cy - y - 0.5) / camera.focal * Eigen::Vector3d::UnitZ();
      const double a = ray.head<2>().squaredNorm(), b = ray.head<2>().dot(camera.centre.head<2>());
      const double t = (-b + std::sqrt(b * b + a * (radius * radius - 1))) / a;
      const Eigen::Vector3d hit = camera.centre + t * ray;
      frame.columns.row(x)[y] = static_cast<uint8_t>(paint(std::atan2(hit.y(), hit.x()), hit.z() * w));
    }
  return frame;
}

std::vector<UprightFrame> pictures(double w) {
  std::vector<UprightFrame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(picture_of_cylinder(0.3 - 0.15 * i, w, i));
  return frames;
}

struct Costs {
  std::vector<uint8_t> cost, grey;
};

Costs read(const CostVolume& sweep, const Window& window) {
  const auto size = static_cast<size_t>(window.width * window.height * sweep.labels());
  Costs costs{std::vector<uint8_t>(size), std::vector<uint8_t>(size)};
  sweep.read(window, costs.cost.data(), costs.grey.data());
  return costs;
}

TEST(CostVolume, SurfacesOfOneGreyAreToldByTheirTint) {
  const int label = 9;
  const double w = 0.6 * label / 15;
  const PanoramaGrid grid = simple_grid(0.6);
  std::vector<UprightFrame> frames = pictures(w);
  for (UprightFrame& frame : frames) {
    frame.tint = frame.columns;
    std::fill(frame.columns.samples.begin(), frame.columns.samples.end(), uint8_t{100});
  }
  const CostVolume sweep(frames, grid, {}, {}, {});
  const Costs costs = read(sweep, {40, 20, 20, 20});
  for (size_t pixel = 0; pixel < 400; ++pixel) {
    const auto first = costs.cost.begin() + static_cast<std::ptrdiff_t>(16 * pixel);
    EXPECT_EQ(std::min_element(first, first + 16) - first, label);
  }
}

// Of a surface without texture: slow shading of so many levels, which differs from picture to picture.
std::vector<UprightFrame> shaded_pictures(int levels) {
  std::vector<UprightFrame> frames = pictures(0.25);
  for (size_t i = 0; i < frames.size(); ++i) {
    const UprightCamera& camera = frames[i].camera;
    for (int x = 0; x < camera.width; ++x)
      std::fill_n(frames[i].columns.row(x), camera.height,
                  static_cast<uint8_t>(100 + levels * std::abs((x + 7 * static_cast<int>(i)) % 24 - 12) / 12));
  }
  return frames;
}

int costs_of_a_pixel(const Costs& costs, size_t pixel) {
  const auto first = costs.cost.begin() + static_cast<std::ptrdiff_t>(16 * pixel);
  return static_cast<int>(std::set<int>(first, first + 16).size());
}

TEST(CostVolume, SmallDifferencesOfAPlainSurfaceTellNoLabelsApart) {
  const PanoramaGrid grid = simple_grid(0.6);
  const Window window{30, 15, 40, 30};
  const Costs plain = read(CostVolume(shaded_pictures(4), grid, {}, {}, {}), window),
              textured = read(CostVolume(shaded_pictures(36), grid, {}, {}, {}), window);
  for (size_t pixel = 0; pixel < 1200; ++pixel) {
    ASSERT_EQ(costs_of_a_pixel(plain, pixel), 1) << pixel;
    ASSERT_GT(costs_of_a_pixel(textured, pixel), 4) << pixel;
  }
}

TEST(CostVolume, PlainSurfacesAreDrawnToFeaturePoints) {
  const PanoramaGrid grid = simple_grid(0.6);
  std::vector<ScenePoint> points;
  for (int x = 20; x < 80; x += 4)
    for (int y = 8; y < 56; y += 4)
      points.push_back({grid.point(grid.theta(x), grid.v(y), grid.w_far + (grid.w_near - grid.w_far) * 0.4), {0, 1}});
  SweepOptions with;
  with.points = &points;
  const Window window{30, 15, 40, 30};
  const Costs drawn = read(CostVolume(shaded_pictures(4), grid, {}, {}, with), window),
              plain = read(CostVolume(shaded_pictures(4), grid, {}, {}, {}), window);
  for (size_t i = 0; i < drawn.cost.size(); ++i) {
    const int beyond = std::max(0, std::abs(static_cast<int>(i % 16) - 6) - 1);
    ASSERT_EQ(drawn.cost[i], plain.cost[i] + (std::min(beyond, 6) + 1) / 2) << i;
  }
  EXPECT_EQ(read(CostVolume(shaded_pictures(40), grid, {}, {}, with), window).cost,
            read(CostVolume(shaded_pictures(40), grid, {}, {}, {}), window).cost);
  const DisparityMap front(grid.width, grid.height, 9 * kDisparitySteps / 15);
  EXPECT_EQ(read(CostVolume(shaded_pictures(4), grid, {}, front, with), window).cost,
            read(CostVolume(shaded_pictures(4), grid, {}, front, {}), window).cost);
}

TEST(CostVolume, APlainSurfaceIsStillToldFromAnotherOne) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto halves = [](double theta, double) { return theta > 0 ? 100.0 : 160.0; };
  const std::vector<UprightFrame> frames = {picture_of_cylinder(0.2, 0.36, 0, halves),
                                            picture_of_cylinder(-0.2, 0.36, 1, halves)};
  const Costs costs = read(CostVolume(frames, grid, {}, {}, {}), {30, 20, 40, 1});
  int others = 0, equal = 0;
  for (const uint8_t cost : costs.cost) {
    others += cost > 20;
    equal += cost == 16;
  }
  EXPECT_GT(others, 30);
  EXPECT_GT(equal, 100);
}

TEST(CostVolume, PlainSurfacesCostTheSameInAnyWindow) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto frames = shaded_pictures(9);
  DisparityMap front(grid.width, grid.height, 9 * kDisparitySteps / 15);
  for (int y = 0; y < grid.height; y += 2) std::fill_n(front.row(y), grid.width, 4 * kDisparitySteps / 15);
  for (const DisparityMap& behind : {DisparityMap(), front}) {
    const CostVolume sweep(frames, grid, {}, behind, {});
    const Costs whole = read(sweep, {0, 0, grid.width, grid.height});
    for (int y = 10; y < 50; ++y) {
      const Window window{31, y, 9, 1};
      const Costs part = read(sweep, window);
      for (int x = 0; x < window.width; ++x)
        for (int label = 0; label < 16; ++label)
          ASSERT_EQ(part.cost[static_cast<size_t>(x * 16 + label)],
                    whole.cost[static_cast<size_t>(((window.x + x) * grid.height + y) * 16 + label)]);
    }
  }
}

TEST(CostVolume, OnTheFrontLayerTheNearestCameraSeesWhatOthersDoNot) {
  const PanoramaGrid grid = simple_grid(0.6);
  const std::vector<UprightFrame> frames = pictures(0.36);
  std::vector<VisibilityMap> hiding(frames.size());  // all beyond a depth of 5
  for (size_t i = 0; i < frames.size(); ++i) {
    hiding[i].inverse_z = Plane<uint16_t>(frames[i].camera.height, frames[i].camera.width, 2000);
    hiding[i].scale = 1e-4;
  }
  const SweepOptions options;
  const Window window{40, 20, 10, 10};
  const Costs front = read(CostVolume(frames, grid, hiding, {}, options), window);
  const DisparityMap nearest(grid.width, grid.height, kDisparitySteps);
  const Costs behind = read(CostVolume(frames, grid, hiding, nearest, options), window);
  constexpr int kHidden = 3, kSeen = 9;  // labels at depths 8.3 and 2.8
  EXPECT_EQ(front.cost[kHidden], options.prior_cost);
  EXPECT_EQ(behind.cost[kHidden], kernels::kLargestVariance);
  EXPECT_EQ(front.cost[kSeen], behind.cost[kSeen]);
}

TEST(CostVolume, FindsTheLabelOfACylinderEverywhere) {
  const PanoramaGrid grid = simple_grid(0.6);
  for (const int label : {4, 10, 15}) {
    const auto frames = pictures(grid.inverse_depth(label * kDisparitySteps / 15.0));
    const CostVolume sweep(frames, grid, {}, {}, {});
    const Window window{20, 10, 60, 40};
    const Costs costs = read(sweep, window);
    for (int p = 0; p < window.width * window.height; ++p) {
      const auto* cost = costs.cost.data() + p * 16;
      ASSERT_EQ(std::min_element(cost, cost + 16) - cost, label) << "pixel " << p;
    }
  }
}

TEST(CostVolume, AnyWindowGivesWhatTheWholeGives) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto frames = pictures(0.25);
  const CostVolume sweep(frames, grid, {}, {}, {});
  const Costs whole = read(sweep, {0, 0, grid.width, grid.height});
  for (const Window& window : {Window{0, 0, 7, 9}, Window{93, 51, 7, 9}, Window{31, 0, 1, 60}, Window{0, 17, 100, 1}}) {
    const Costs part = read(sweep, window);
    for (int x = 0; x < window.width; ++x)
      for (int i = 0; i < window.height * 16; ++i) {
        const auto at = static_cast<size_t>(x * window.height * 16 + i);
        const auto in_whole = static_cast<size_t>(((window.x + x) * grid.height + window.y) * 16 + i);
        ASSERT_EQ(part.cost[at], whole.cost[in_whole]) << window.x << "," << window.y << " at " << x << " " << i;
        ASSERT_EQ(part.grey[at], whole.grey[in_whole]);
      }
  }
}

TEST(CostVolume, LabelsInFrontOfTheLayerBeforeAreForbidden) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto frames = pictures(0.25);
  const DisparityMap front(grid.width, grid.height, 8 * kDisparitySteps / 15);
  const CostVolume sweep(frames, grid, {}, front, {});
  const Costs costs = read(sweep, {50, 30, 1, 1});
  for (size_t label = 0; label < 16; ++label) EXPECT_EQ(costs.cost[label] == 255, label >= 8) << label;
}

TEST(CostVolume, LabelsBehindHaveTheGreysOfASweepOfAllAndThoseInFrontTheGreyOfTheNearestBehind) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto frames = pictures(0.25);
  DisparityMap front(grid.width, grid.height);
  std::mt19937 random(5);
  for (uint16_t& d : front.samples) d = static_cast<uint16_t>(random() % 3 == 0 ? random() % kDisparitySteps : 0);
  std::fill(front.row(3), front.row(3) + grid.width, kNoDisparity);
  const CostVolume all(frames, grid, {}, {}, {}), behind(frames, grid, {}, front, {});
  const Window window{50, 0, 23, 40};
  const Costs expected = read(all, window), found = read(behind, window);
  size_t at = 0;
  for (int x = window.x; x < window.x + window.width; ++x)
    for (int y = window.y; y < window.y + window.height; ++y, at += 16) {
      const int surface = front.at(x, y);
      int grey = 128;
      for (size_t label = 0; label < 16; ++label) {
        const bool allowed =
            surface == kNoDisparity || (2 * static_cast<int>(label) + 1) * kDisparitySteps < 30 * surface;
        if (allowed) grey = expected.grey[at + label];
        ASSERT_EQ(found.grey[at + label], grey) << x << "," << y << " label " << label;
        ASSERT_EQ(found.cost[at + label] == 255, !allowed);
      }
    }
}

// How many cameras have the voxel well inside their photos, and how many may have it on their border.
std::pair<int, int> cameras_seeing(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid, int x, int y,
                                   double w) {
  int inside = 0, maybe = 0;
  const double theta = grid.theta(x + 0.5), v = grid.v(y + 0.5);
  const Eigen::Vector3d outward(std::cos(theta), std::sin(theta), 0);
  for (const UprightFrame& frame : frames) {
    const UprightCamera& camera = frame.camera;
    const Eigen::Vector3d q = (outward - camera.centre) * w + outward + v * Eigen::Vector3d::UnitZ();
    const double scale = camera.focal / q.dot(camera.forward);
    const double border =
        std::min({scale * q.dot(camera.right) + camera.cx, camera.width - scale * q.dot(camera.right) - camera.cx,
                  camera.cy - scale * q.z(), camera.height - camera.cy + scale * q.z()});
    inside += border > 2;
    maybe += border > -1;
  }
  return {inside, maybe};
}

TEST(CostVolume, WhatFewerThanTwoCamerasSeeCostsLittleMoreThanTheBestMatch) {
  const PanoramaGrid grid = simple_grid(0.6);
  const std::vector<UprightFrame> frames = {picture_of_cylinder(0.2, 0.25, 0), picture_of_cylinder(-0.2, 0.25, 1)};
  SweepOptions dear, wide;
  dear.margin = 255, dear.unmatched_cost = wide.unmatched_cost = dear.prior_cost;
  const Window whole{0, 0, grid.width, grid.height};
  const Costs costs = read(CostVolume(frames, grid, {}, {}, {}), whole),
              relative = read(CostVolume(frames, grid, {}, {}, wide), whole),
              old = read(CostVolume(frames, grid, {}, {}, dear), whole);
  int unmatched = 0;
  for (int p = 0; p < grid.width * grid.height; ++p) {
    const uint8_t *cost = costs.cost.data() + p * 16, *near_best = relative.cost.data() + p * 16,
                  *before = old.cost.data() + p * 16;
    int least = dear.prior_cost;
    bool sure = true;
    std::array<bool, 16> twice{};
    for (int label = 0; label < 16; ++label) {
      const double w = grid.inverse_depth(label * kDisparitySteps / 15.0);
      const auto [inside, maybe] = cameras_seeing(frames, grid, p / grid.height, p % grid.height, w);
      twice[static_cast<size_t>(label)] = inside > 1;
      sure = sure && (inside > 1) == (maybe > 1);
      if (inside > 1) least = std::min<int>(least, before[label]);
    }
    for (int label = 0; sure && label < 16; ++label) {
      const bool matched = twice[static_cast<size_t>(label)];
      const int wanted = matched ? before[label] : std::min<int>(before[label], std::min(least + 2, dear.prior_cost));
      ASSERT_EQ(near_best[label], wanted) << p << " label " << label;
      ASSERT_EQ(cost[label], matched ? wanted : std::min(wanted, 8)) << p << " label " << label;
      unmatched += !matched && wanted < dear.prior_cost;
    }
  }
  EXPECT_GT(unmatched, 500);
}

TEST(CostVolume, RefusesOptionsOutsideTheirRange) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto frames = pictures(0.25);
  SweepOptions options;
  options.substeps = 0;
  EXPECT_THROW(CostVolume(frames, grid, {}, {}, options), std::logic_error);
  EXPECT_THROW(CostVolume(frames, grid, {}, DisparityMap(3, 3), {}), std::logic_error);
  EXPECT_THROW(CostVolume(frames, grid, std::vector<VisibilityMap>(2), {}, {}), std::logic_error);
}

// Within the range but for what meets theta from -0.3 to -0.06, which is nearer by half.
std::vector<UprightFrame> pictures_with_something_nearer(double w) {
  std::vector<UprightFrame> frames = pictures(w);
  for (int i = 0; i < 5; ++i) {
    const UprightFrame nearer = picture_of_cylinder(0.3 - 0.15 * i, 1.5 * w, i, [](double theta, double height) {
      return std::abs(theta + 0.18) < 0.12 ? texture(theta, height) : 0;
    });
    for (size_t k = 0; k < nearer.columns.samples.size(); ++k)
      if (nearer.columns.samples[k] > 0) frames[static_cast<size_t>(i)].columns.samples[k] = nearer.columns.samples[k];
  }
  return frames;
}

// Which of cameras at these angles are compared in the middle of the grid, the first of them first.
std::vector<int> compared(const std::vector<double>& thetas) {
  std::vector<UprightFrame> frames;
  for (size_t i = 0; i < thetas.size(); ++i) {
    frames.push_back(upright_of(camera_at(thetas[i]), static_cast<int>(i)));
    std::fill(frames[i].columns.samples.begin(), frames[i].columns.samples.end(), static_cast<uint8_t>(i));
  }
  const std::vector<VisibilityMap> none;
  const LineTable table(frames, simple_grid(0.6), none, 0, LineTable::Layer::front);
  Lines lines;
  table.find(50, 0.2, 0, 60, lines);
  std::vector<int> numbers;
  for (size_t i = 0; i < static_cast<size_t>(lines.count); ++i) numbers.push_back(*lines.line[i].grey.left);
  if (!numbers.empty()) std::sort(numbers.begin() + 1, numbers.end());
  return numbers;
}

// The middle, and in turn to either side of it.
std::vector<double> steps(int aside, double step) {
  std::vector<double> thetas{0};
  for (int i = 1; i <= aside; ++i) thetas.insert(thetas.end(), {-i * step, i * step});
  return thetas;
}

TEST(LineTable, ComparesCamerasThatStandApartWhereTheNearestAreCloseTogether) {
  EXPECT_EQ(compared(steps(5, 0.1)), (std::vector{0, 1, 2, 3, 4, 5, 6, 7})) << "no closer than that";
  EXPECT_EQ(compared({0, 0.01, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3, 0.4}), (std::vector{0, 1, 2, 3, 4, 5, 6, 7}))
      << "two may be, where the others are not";
  EXPECT_EQ(compared(steps(20, 0.02)), (std::vector{0, 7, 8, 15, 16, 23, 24, 31})) << "each fourth";
  EXPECT_EQ(compared(steps(5, 0.02)), (std::vector{0, 1, 2, 3, 4, 5, 7, 8})) << "and those between where few do";
  EXPECT_EQ(compared(steps(3, 0.02)), (std::vector{0, 1, 2, 3, 4, 5, 6})) << "or there are no more";
}

TEST(MatchedNear, TakesInWhatMatchesNearerThanTheRange) {
  const PanoramaGrid grid = simple_grid(0.6);
  for (const double times : {1.2, 1.35})
    EXPECT_NEAR(matched_near(pictures(times * grid.w_near), grid, {}) / grid.w_near, times, 0.1);
  EXPECT_NEAR(matched_near(pictures_with_something_nearer(0.55), grid, {}) / grid.w_near, 1.5 * 0.55 / 0.6, 0.1);
}

TEST(MatchedNear, IsTheRangesWhereAllMatchesWithinItOrNothingDoes) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto plain = [](double, double) { return 100.0; };
  std::vector<UprightFrame> wall, unlike;
  for (int i = 0; i < 5; ++i) {
    wall.push_back(picture_of_cylinder(0.3 - 0.15 * i, 0.9, i, plain));
    unlike.push_back(picture_of_cylinder(0.3 - 0.15 * i, 0.2 + 0.9 * i, i));
  }
  const double beside = 1.1 * grid.w_near;  // as near as a label's reach: that may be the range's own
  const auto pale = [](double theta, double height) { return 100 + texture(theta, height) / 8; };
  std::vector<UprightFrame> little;
  for (int i = 0; i < 5; ++i) little.push_back(picture_of_cylinder(0.3 - 0.15 * i, 0.8, i, pale));
  for (const auto& frames : {pictures(0.25), pictures(0.6), pictures(beside), wall, unlike, little})
    EXPECT_EQ(matched_near(frames, grid, {}), grid.w_near);
}

TEST(MatchedNear, IsTheSameAtAnyThreadCountAndLeavesGridsAloneThatHoldNoBlockOrNoDepths) {
  PanoramaGrid grid = simple_grid(0.6);
  const auto frames = pictures(0.78);
  Job one, three;
  one.threads = 1, three.threads = 3;
  EXPECT_EQ(matched_near(frames, grid, one), matched_near(frames, grid, three));
  for (const auto& [width, height, w_far] : {std::tuple{100, 7, 0.0}, {7, 60, 0.0}, {100, 60, 0.6}, {100, 60, 0.9}}) {
    grid.width = width, grid.height = height, grid.w_far = w_far;
    EXPECT_EQ(matched_near(frames, grid, one), grid.w_near) << width << "x" << height << " from " << w_far;
  }
}

TEST(Refine, FindsDepthsBetweenLabels) {
  const PanoramaGrid grid = simple_grid(0.6);
  for (const double label : {4.3, 9.6, 12.45}) {
    const auto frames = pictures(grid.inverse_depth(label * kDisparitySteps / 15));
    const CostVolume sweep(frames, grid, {}, {}, {});
    const Plane<uint8_t> labels(grid.width, grid.height, static_cast<uint8_t>(std::lround(label)));
    const DisparityMap refined = refine(sweep, labels, {}, {});
    for (int y = 10; y < 50; ++y)
      for (int x = 20; x < 80; ++x)
        ASSERT_NEAR(refined.at(x, y) * 15.0 / kDisparitySteps, label, 0.06) << x << "," << y;
  }
}

TEST(Refine, LeavesOutWhatTheMaskLeavesOutAndIsTheSameAtAnyThreadCount) {
  const PanoramaGrid grid = simple_grid(0.6);
  const auto frames = pictures(0.25);
  const CostVolume sweep(frames, grid, {}, {}, {});
  const Plane<uint8_t> labels(grid.width, grid.height, 6);
  Plane<uint8_t> mask(grid.width, grid.height, 0);
  for (int y = 20; y < 30; ++y) std::fill(mask.row(y) + 40, mask.row(y) + 60, uint8_t{1});
  Job one, eight;
  one.threads = 1, eight.threads = 8;
  const DisparityMap refined = refine(sweep, labels, mask, one);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) ASSERT_EQ(refined.at(x, y) == kNoDisparity, mask.at(x, y) == 0);
  EXPECT_EQ(refined, refine(sweep, labels, mask, eight));
}

TEST(Smooth, MovesAnOutlineToTheEdgeOfTheImageAndRemovesNoise) {
  DisparityMap disparity(60, 40);
  Plane<uint8_t> guide(60, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x) {
      const bool near = x < 30;
      guide.at(x, y) = near ? 60 : 180;
      disparity.at(x, y) = static_cast<uint16_t>((x < 33 ? 3000 : 600) + (x * 7 + y * 13) % 40 - 20);  // 3 px too wide
    }
  const DisparityMap out = smooth(disparity, guide, false, {});
  for (int y = 6; y < 34; ++y)
    for (int x = 6; x < 54; ++x) ASSERT_NEAR(out.at(x, y), x < 30 ? 3000 : 600, 8) << x << "," << y;
}

TEST(Smooth, LooksAcrossTheSeamOfAGridThatWraps) {
  DisparityMap disparity(40, 12, 1000);
  const Plane<uint8_t> guide(40, 12, 100);
  for (int y = 0; y < 12; ++y) std::fill(disparity.row(y), disparity.row(y) + 5, uint16_t{2000});
  EXPECT_EQ(smooth(disparity, guide, false, {}).at(0, 6), 2000);  // 5 of the 6 columns that it sees
  EXPECT_EQ(smooth(disparity, guide, true, {}).at(0, 6), 1000);   // 5 of 11
}

constexpr int kLabelSteps = 255;

// Noise of a third of a label everywhere, but a column every 20 that is known.
struct NoisyPlane {
  DisparityMap disparity{96, 48};
  Plane<uint8_t> firmness{96, 48, 0}, guide{96, 48, 100};

  NoisyPlane() {
    std::mt19937 random(3);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 96; ++x) {
        const bool known = x % 20 == 0;
        disparity.at(x, y) = static_cast<uint16_t>(1000 + 2 * x + (known ? 0 : static_cast<int>(random() % 170) - 85));
        firmness.at(x, y) = known ? 255 : 1;
      }
  }
  double error() const {
    const DisparityMap out = weak_membrane(disparity, firmness, guide, kLabelSteps, false, {});
    double squares = 0;
    for (int y = 8; y < 40; ++y)
      for (int x = 8; x < 88; ++x) squares += (out.at(x, y) - 1000 - 2 * x) * (out.at(x, y) - 1000 - 2 * x);
    return std::sqrt(squares / (32 * 80));
  }
};

TEST(WeakMembrane, WhatIsKnownDrawsWhatIsNotWhereThePictureIsPlain) {
  NoisyPlane plane;
  EXPECT_LT(plane.error(), 12);  // of a noise of 49; without the known columns it is more than that
  for (int y = 0; y < 48; y += 5)
    for (int x = 0; x < 96; x += 5) plane.guide.at(x, y) = 160;  // no longer plain: ties break at a sixth of a label
  EXPECT_GT(plane.error(), 20);
}

TEST(WeakMembrane, BreaksAtDepthEdgesAndAtEdgesOfTheImage) {
  DisparityMap disparity(40, 12, 1000);
  const Plane<uint8_t> firmness(40, 12, 8);
  Plane<uint8_t> guide(40, 12, 100);
  for (int y = 0; y < 12; ++y) {
    std::fill(disparity.row(y) + 25, disparity.row(y) + 40, static_cast<uint16_t>(1000 + kLabelSteps + 1));
    std::fill(guide.row(y) + 10, guide.row(y) + 20, uint8_t{200});
    std::fill(disparity.row(y) + 10, disparity.row(y) + 20, uint16_t{1030});  // less than ties bear
  }
  EXPECT_EQ(weak_membrane(disparity, firmness, guide, kLabelSteps, false, {}), disparity);
}

TEST(WeakMembrane, LeavesAbsentPixelsAndGoesOnAcrossTheSeam) {
  DisparityMap disparity(30, 8, 1000);
  for (int y = 0; y < 8; ++y) {
    disparity.at(29, y) = 1100;
    disparity.at(13, y) = 1100;
    disparity.at(14, y) = kNoDisparity;
  }
  Plane<uint8_t> firmness(30, 8, 1), guide(30, 8, 100);
  for (int y = 0; y < 8; ++y) firmness.at(14, y) = guide.at(14, y) = 0;  // no contrast to what is absent
  const DisparityMap open = weak_membrane(disparity, firmness, guide, kLabelSteps, false, {}),
                     closed = weak_membrane(disparity, firmness, guide, kLabelSteps, true, {});
  EXPECT_EQ(open.at(14, 3), kNoDisparity);
  EXPECT_LT(open.at(13, 3), 1050);  // plain as far as it is present
  EXPECT_EQ(open.at(0, 3), 1000);
  EXPECT_GT(closed.at(0, 3), 1005);
  EXPECT_EQ(closed.at(15, 3), closed.at(15, 4));
}

TEST(WeakMembrane, IsTheSameAtAnyThreadCountAndStopsWhenAsked) {
  const NoisyPlane plane;
  Job one, eight;
  one.threads = 1, eight.threads = 8;
  const auto result = [&](const Job& job) {
    return weak_membrane(plane.disparity, plane.firmness, plane.guide, kLabelSteps, false, job);
  };
  EXPECT_EQ(result(one), result(eight));
  std::stop_source source;
  source.request_stop();
  one.stop = source.get_token();
  EXPECT_THROW(result(one), Cancelled);
}

}  // namespace
}  // namespace ldp::sweep
