#include "tests/bench/edges/slender_things.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/scene/picture.h"
#include "sim/scene/scenes.h"
#include "sim/scene/sweep_path.h"

namespace ldp {
namespace {

// A camera at the origin that looks along x, z up.
Camera camera_of(int width, int height, double focal_px) {
  Camera camera;
  camera.intrinsics = {width, height, focal_px, focal_px, width / 2.0, height / 2.0};
  camera.pose.world_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return camera;
}

// A white upright bar 4 m ahead before a black wall; `length` of it is there, from its lower end.
SceneDescription bar(double radius, double length) {
  SceneDescription description;
  description.has_ground = false;
  Object wall, rod;
  wall.centre = {9, 0, 0};
  wall.half = {1, 20, 20};
  wall.material.dark = wall.material.light = wall.material.accent = {0, 0, 0};
  rod.shape = Shape::cylinder;
  rod.centre = {4, 0, length / 2 - 1};
  rod.half = {radius, 0, length / 2};
  rod.material.dark = rod.material.light = rod.material.accent = {1, 1, 1};
  description.objects = {wall, rod};
  return description;
}

constexpr double kWhole = 2;  // metres of the bar: 100 px

TrueView true_view(const SceneDescription& description) {
  const Camera camera = camera_of(160, 120, 200);
  Picture picture = take_picture(Scene(description), camera, {}, {});
  return {camera, std::move(picture.colour), std::move(picture.depth)};
}

View shown(const SceneDescription& description) {
  TrueView view = true_view(description);
  return {view.colour, Plane<uint8_t>(view.colour.width, view.colour.height, 255), view.z, 0};
}

SlenderLength total(const SlenderLengths& lengths) {
  SlenderLength all;
  for (const SlenderLength& of_width : lengths) all.add(of_width);
  return all;
}

SlenderLengths lengths_of(const SceneDescription& truth, const View& rendering) {
  return slender_lengths(Scene(truth), true_view(truth), rendering);
}

TEST(SlenderThings, StandWholeInTheTrueView) {
  const SlenderLengths lengths = lengths_of(bar(0.03, kWhole), shown(bar(0.03, kWhole)));
  EXPECT_NEAR(static_cast<double>(lengths[1].shown), 100, 2);  // 3 px wide
  EXPECT_EQ(lengths[1].standing, lengths[1].shown);
  EXPECT_EQ(lengths[1].longest_break, 0);
  EXPECT_EQ(total(lengths).shown, lengths[1].shown);
}

TEST(SlenderThings, AreToldByTheirWidth) {
  for (const auto& [radius, of_width] : {std::pair(0.015, 0), {0.03, 1}, {0.05, 2}}) {
    const SlenderLengths lengths = lengths_of(bar(radius, kWhole), shown(bar(radius, kWhole)));
    EXPECT_GT(lengths[static_cast<size_t>(of_width)].shown, 90) << radius;
    EXPECT_EQ(total(lengths).shown, lengths[static_cast<size_t>(of_width)].shown) << radius;
  }
}

TEST(SlenderThings, DoNotStandWhereTheirBackgroundIsShown) {
  const SlenderLengths lengths = lengths_of(bar(0.03, kWhole), shown(bar(0.03, 0.6 * kWhole)));
  EXPECT_NEAR(static_cast<double>(lengths[1].standing), 0.6 * static_cast<double>(lengths[1].shown), 3);
  EXPECT_EQ(lengths[1].longest_break, lengths[1].shown - lengths[1].standing);
}

TEST(SlenderThings, DoNotStandInHoles) {
  View rendering = shown(bar(0.03, kWhole));
  for (int y = 40; y < 50; ++y)
    for (int x = 0; x < rendering.alpha.width; ++x) rendering.alpha.at(x, y) = 0;
  const SlenderLength all = total(lengths_of(bar(0.03, kWhole), rendering));
  EXPECT_NEAR(static_cast<double>(all.longest_break), 10, 1);
}

TEST(SlenderThings, AreNotAskedForWhereOthersHideThem) {
  SceneDescription two = bar(0.03, kWhole);
  Object nearer = two.objects.back();
  nearer.centre = {2, 0, -0.25};  // hides the lower half
  nearer.half = {0.02, 0, 0.25};
  two.objects.push_back(nearer);
  const SlenderLengths lengths = lengths_of(two, shown(two));
  EXPECT_NEAR(static_cast<double>(lengths[1].shown), 50, 2);  // 3 px wide
  EXPECT_NEAR(static_cast<double>(lengths[2].shown), 50, 2);  // 4 px wide
}

TEST(SlenderThings, StandAPixelBesideTheirPlaceButNotThree) {
  for (const auto& [px, stands] : {std::pair(1, true), {4, false}}) {
    View rendering = shown(bar(0.03, kWhole));
    for (int y = 0; y < rendering.colour.height; ++y)
      std::rotate(rendering.colour.row(y), rendering.colour.row(y) + rendering.colour.width - px,
                  rendering.colour.row(y) + rendering.colour.width);
    const SlenderLength all = total(lengths_of(bar(0.03, kWhole), rendering));
    EXPECT_EQ(all.standing, stands ? all.shown : 0) << px;
  }
}

TEST(SlenderThings, AreOfAllWidthsInTheSceneOfRailings) {
  const Scene scene(make_scene("railings", 1));
  SlenderLengths lengths;
  SweepPath half;  // the middle of the views
  half.width /= 2;
  half.fov_rad = 2 * std::atan(std::tan(half.fov_rad / 2) / 2);
  const std::vector<Camera> cameras = novel_cameras(half);
  for (const size_t view : {0U, 2U}) {
    Picture picture = take_picture(scene, cameras[view], {}, {});
    const View perfect{picture.colour, Plane<uint8_t>(half.width, half.height, 255), picture.depth, 0};
    const SlenderLengths found =
        slender_lengths(scene, {cameras[view], std::move(picture.colour), std::move(picture.depth)}, perfect);
    for (size_t k = 0; k < kSlenderClasses; ++k) lengths[k].add(found[k]);
  }
  for (const SlenderLength& of_width : lengths) {
    EXPECT_GT(of_width.shown, 100);
    EXPECT_EQ(of_width.standing, of_width.shown);
  }
}

}  // namespace
}  // namespace ldp
