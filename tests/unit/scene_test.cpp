#include "sim/scene/scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/npy.h"
#include "sim/scene/crowd.h"
#include "sim/scene/picture.h"
#include "sim/scene/random.h"
#include "sim/scene/scenes.h"
#include "sim/scene/surround.h"
#include "sim/scene/sweep_path.h"
#include "sim/scene_capture.h"

namespace ldp {
namespace {

using Eigen::Vector3d;

SceneDescription only(const Object& object) {
  SceneDescription description;
  description.has_ground = false;
  description.objects = {object};
  return description;
}

Object at(Shape shape, const Vector3d& centre, const Vector3d& half) {
  Object object;
  object.shape = shape;
  object.centre = centre;
  object.half = half;
  return object;
}

double distance(const SceneDescription& description, const Vector3d& origin, const Vector3d& direction) {
  return Scene(description).first_hit({origin, direction, 0.001}).t;
}

Camera small_camera(int width, int height) {
  SweepPath path;
  path.width = width;
  path.height = height;
  path.frames = 3;
  return sweep_cameras(path)[1];
}

TEST(Scene, MeetsEveryShapeAtItsKnownDistance) {
  const Vector3d origin(0, 0, 0), ahead(1, 0, 0), centre(5, 0, 0);
  EXPECT_DOUBLE_EQ(distance(only(at(Shape::ellipsoid, centre, {2, 1, 1})), origin, ahead), 3);
  EXPECT_DOUBLE_EQ(distance(only(at(Shape::box, centre, {1, 2, 3})), origin, ahead), 4);
  EXPECT_DOUBLE_EQ(distance(only(at(Shape::cylinder, centre, {0.5, 0, 1})), origin, ahead), 4.5);
  Object wall = at(Shape::quad, centre, {1, 1, 0});
  wall.world_from_local = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR(distance(only(wall), origin, ahead), 5, 1e-12);
}

TEST(Scene, CountsDistanceInLengthsOfTheDirection) {
  EXPECT_DOUBLE_EQ(distance(only(at(Shape::box, {5, 0, 0}, {1, 1, 1})), {0, 0, 0}, {2, 0, 0}), 2);
}

TEST(Scene, MeetsTheLidOfACylinderFromAbove) {
  EXPECT_DOUBLE_EQ(distance(only(at(Shape::cylinder, {0, 0, 0}, {0.5, 0, 1})), {0.2, 0, 4}, {0, 0, -1}), 3);
}

TEST(Scene, SeesTheSkyWhereNothingIs) {
  const Hit hit = Scene(only(at(Shape::box, {5, 0, 0}, {1, 1, 1}))).first_hit({{0, 0, 0}, {0, 1, 0}, 0.001});
  EXPECT_TRUE(std::isinf(hit.t));
  EXPECT_EQ(hit.object, -1);
}

TEST(Scene, GoesThroughTheCornersOfALeaf) {
  const SceneDescription leaf = only(at(Shape::leaf, {0, 0, 0}, {1, 0.5, 0}));
  EXPECT_DOUBLE_EQ(distance(leaf, {0, 0, 2}, {0, 0, -1}), 2);
  EXPECT_TRUE(std::isinf(distance(leaf, {0.9, 0.45, 2}, {0, 0, -1})));
}

TEST(Scene, ListsWhatLiesBehindInOrder) {
  SceneDescription description = only(at(Shape::box, {5, 0, 0}, {1, 1, 1}));
  description.objects.push_back(at(Shape::ellipsoid, {9, 0, 0}, {1, 1, 1}));
  description.objects.push_back(at(Shape::cylinder, {2, 0, 0}, {0.1, 0, 1}));
  const std::vector<Hit> hits = Scene(description).hits({{0, 0, 0}, {1, 0, 0}, 0.001}, 9);
  ASSERT_EQ(hits.size(), 4U);
  EXPECT_NEAR(hits[0].t, 1.9, 1e-12);
  EXPECT_DOUBLE_EQ(hits[1].t, 4);
  EXPECT_DOUBLE_EQ(hits[2].t, 8);
  EXPECT_TRUE(std::isinf(hits[3].t));
  EXPECT_EQ(Scene(description).hits({{0, 0, 0}, {1, 0, 0}, 0.001}, 2).size(), 2U);
}

TEST(Scene, FindsTheSameAsLookingAtEveryObject) {
  const SceneDescription garden = make_scene("garden", 3);
  SceneDescription bare = garden;
  bare.has_ground = false;
  bare.hills.clear();
  const Scene scene(bare);
  std::vector<Scene> single;
  for (const Object& object : bare.objects) {
    SceneDescription one = bare;
    one.objects = {object};
    single.emplace_back(std::move(one));
  }
  Random random(5);
  for (int i = 0; i < 60; ++i) {
    const Vector3d origin{random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 1.6};
    const Vector3d direction{random.normal(), random.normal(), 0.4 * random.normal()};
    double nearest = std::numeric_limits<double>::infinity();
    for (const Scene& one : single) nearest = std::min(nearest, one.first_hit({origin, direction, 0.001}).t);
    EXPECT_EQ(scene.first_hit({origin, direction, 0.001}).t, nearest);
  }
}

TEST(Scene, EveryNamedOneHasThingsWithinReachAndAnEnd) {
  for (const std::string& name : scene_names()) {
    const Plane<float> depth = take_depth(Scene(make_scene(name, 1)), small_camera(64, 48), {});
    const auto [nearest, farthest] = std::minmax_element(depth.samples.begin(), depth.samples.end());
    EXPECT_GT(*nearest, 0.3F) << name;
    EXPECT_LT(*nearest, 8.0F) << name;
    EXPECT_GT(*farthest, 1.5F) << name;
  }
}

TEST(Scene, RefusesAnUnknownNameByListingTheKnownOnes) {
  try {
    make_scene("moon", 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'moon'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("courtyard"), std::string::npos);
  }
}

TEST(Scene, MovesOnlyTheShareThatWasAskedFor) {
  const SceneDescription still = make_scene("figures", 1);
  const auto moved_count = [&](double share) {
    const SceneDescription later = moved(still, share, 4, 1);
    size_t count = 0;
    for (size_t i = 0; i < still.objects.size(); ++i)
      count += still.objects[i].centre != later.objects[i].centre ? 1U : 0U;
    return count;
  };
  EXPECT_EQ(moved_count(0), 0U);
  EXPECT_GT(moved_count(0.5), 0U);
  EXPECT_LT(moved_count(0.5), moved_count(1));
}

// Of each picture of a sweep, the share that changes when people walk by.
std::vector<double> hidden_shares(double crowd) {
  SceneCaptureOptions options;
  options.path.frames = 9, options.path.arc_rad = 2, options.path.width = 120, options.path.height = 90;
  options.path.position_jitter = options.path.angle_jitter_rad = 0;
  const SceneSweep empty(options);
  options.crowd = crowd;
  const SceneSweep crowded(options);
  std::vector<double> shares;
  for (int i = 0; i < options.path.frames; ++i) {
    const RgbImage without = empty.take(i, {}).colour, with = crowded.take(i, {}).colour;
    double changed = 0;
    for (size_t k = 0; k < with.samples.size(); ++k) changed += with.samples[k] == without.samples[k] ? 0 : 1;
    shares.push_back(changed / static_cast<double>(with.samples.size()));
  }
  return shares;
}

TEST(Crowd, HidesAboutTheShareThatWasAskedForOfTheFullestPicture) {
  for (const double share : {0.15, 0.3}) {
    const std::vector<double> hidden = hidden_shares(share);
    EXPECT_NEAR(*std::max_element(hidden.begin(), hidden.end()), share, 0.3 * share) << share;
    EXPECT_GT(*std::min_element(hidden.begin(), hidden.end()), 0) << share;
  }
  EXPECT_EQ(hidden_shares(0), std::vector<double>(9, 0.0));
}

TEST(Crowd, WalksOnFromFrameToFrameAndStandsNowhereInThePhotographersWay) {
  const SweepPath path;
  const SceneDescription empty = make_scene("terrace", 1);
  const auto walkers = [&](int frame) {
    std::vector<Vector3d> places;
    const SceneDescription crowded = with_crowd(empty, path, 0.3, frame, 1);
    for (size_t i = empty.objects.size(); i < crowded.objects.size(); ++i) places.push_back(crowded.objects[i].centre);
    return places;
  };
  const std::vector<Vector3d> first = walkers(0), later = walkers(1);
  ASSERT_EQ(first.size(), later.size());
  ASSERT_GT(first.size(), 20U);
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_NE(first[i], later[i]);
    EXPECT_LT((first[i] - later[i]).norm(), 1);
    EXPECT_GT(first[i].head<2>().norm(), path.radius + 0.8);
  }
  EXPECT_EQ(walkers(1), later);
}

TEST(Picture, IsTheSameWithAnyNumberOfThreads) {
  const Scene scene(make_scene("courtyard", 1));
  PictureOptions options;
  options.noise = 3;
  Job one, three;
  three.threads = 3;
  const Camera camera = small_camera(80, 61);
  EXPECT_EQ(take_picture(scene, camera, options, one).colour, take_picture(scene, camera, options, three).colour);
}

TEST(Picture, DepthIsThatOfTheRayThroughThePixelsCentre) {
  const Scene scene(make_scene("room", 2));
  Camera camera = small_camera(40, 30);
  camera.intrinsics.k1 = -0.1;
  const Plane<float> depth = take_depth(scene, camera, {});
  const Vector3d ray = camera.pose.world_from_camera * unproject(camera.intrinsics, {12.5, 20.5});
  EXPECT_FLOAT_EQ(depth.at(12, 20),
                  static_cast<float>(scene.first_hit({camera.pose.centre, ray, 1 / camera.intrinsics.fx}).t));
}

TEST(Picture, AveragesAnEdgeThatCrossesAPixel) {
  SceneDescription description;
  description.has_ground = false;
  description.cloud_cover = 0;
  Object wall = at(Shape::box, {0, 50, 0}, {50, 0.1, 50});
  wall.centre.x() = 50;  // the right half of the view
  wall.material.pattern = Pattern::plain;
  wall.material.light = {0, 0, 0};
  description.objects = {wall};
  Camera camera;
  camera.intrinsics = {9, 9, 20, 20, 4.5, 4.5, 0, 0, 0, 0};
  camera.pose.world_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const RgbImage picture = take_picture(Scene(description), camera, {}, {}).colour;
  EXPECT_EQ(picture.at(7, 4).b, 0);
  EXPECT_GT(picture.at(1, 4).b, 200);
  EXPECT_GT(picture.at(4, 4).b, 60);
  EXPECT_LT(picture.at(4, 4).b, picture.at(1, 4).b);
}

TEST(Picture, OfAutomaticExposureIsAsBrightInShade) {
  SceneDescription description = make_scene("courtyard", 1);
  const Camera camera = small_camera(80, 61);
  PictureOptions fixed, automatic;
  automatic.meters = true;
  const auto brightness = [&](const PictureOptions& options) {
    double sum = 0;
    const Picture picture = take_picture(Scene(description), camera, options, {});
    for (const Rgb& c : picture.colour.samples) sum += c.g;
    return sum / static_cast<double>(picture.colour.samples.size());
  };
  const double sunny = brightness(fixed), sunny_metered = brightness(automatic);
  description.shade = 0.1F;
  const double shaded = brightness(fixed), shaded_metered = brightness(automatic);
  EXPECT_LT(shaded, 0.9 * sunny) << "half of what is seen";
  EXPECT_NEAR(shaded_metered / sunny_metered, 1, 0.25);
}

TEST(Scene, HasALitAndAShadedHalfThatMeetSoftly) {
  SceneDescription description = make_scene("courtyard", 1);
  const Scene lit(description);
  description.shade = 0.25F;
  const Scene half(description);
  for (const double angle : {0.1, 1.0, 1.57, 2.0, 3.0, -1.0, -2.5})
    for (const double up : {-0.3, 0.0, 0.7}) {
      const Ray ray{{0, 0, 1.5}, {std::cos(angle), std::sin(angle), up}};
      const Hit bright = lit.first_hit(ray), hit = half.first_hit(ray);
      EXPECT_EQ(hit.t, bright.t);
      const double share = static_cast<double>(hit.colour[1] / bright.colour[1]);
      const double across = std::cos(angle);
      const double expected = across > 0.11 ? 1 : across < -0.11 ? 0.25 : 0.625;
      EXPECT_NEAR(share, expected, std::abs(across) > 0.11 ? 1e-6 : 0.05) << angle;
    }
}

TEST(Picture, StopsWhenItsJobIsStopped) {
  std::stop_source stop;
  stop.request_stop();
  Job job;
  job.stop = stop.get_token();
  EXPECT_THROW(take_picture(Scene(make_scene("room", 1)), small_camera(40, 30), {}, job), Cancelled);
}

TEST(SweepPath, LiesOnTheArcAndTurnsRight) {
  SweepPath path;
  path.position_jitter = path.angle_jitter_rad = 0;
  path.radius = 0.7;
  const std::vector<Camera> cameras = sweep_cameras(path);
  ASSERT_EQ(cameras.size(), 20U);
  for (const Camera& camera : cameras) {
    const Vector3d outward = camera.pose.centre - Vector3d(0, 0, path.eye_height);
    EXPECT_NEAR(outward.norm(), 0.7, 1e-12);
    EXPECT_NEAR(outward.normalized().dot(camera.pose.world_from_camera.col(2)), 1, 1e-12);
    EXPECT_NEAR(camera.pose.world_from_camera.determinant(), 1, 1e-12);
    EXPECT_NEAR(camera.pose.world_from_camera(2, 1), -1, 1e-12);
  }
  EXPECT_NEAR(cameras.front().pose.centre.x(), -0.7, 1e-12);
  EXPECT_NEAR(cameras.back().pose.centre.x(), 0.7, 1e-12);
}

TEST(SweepPath, AFullTurnDoesNotRepeatItsFirstFrame) {
  SweepPath path;
  path.arc_rad = 2 * std::numbers::pi;
  path.position_jitter = 0;
  path.frames = 4;
  const std::vector<Camera> cameras = sweep_cameras(path);
  EXPECT_NEAR((cameras[0].pose.centre - cameras[3].pose.centre).norm(), 0.65 * std::numbers::sqrt2, 1e-9);
}

TEST(Npy, RoundsToTheNearestHalf) {
  EXPECT_EQ(half_from_float(0), 0x0000);
  EXPECT_EQ(half_from_float(1), 0x3C00);
  EXPECT_EQ(half_from_float(-2), 0xC000);
  EXPECT_EQ(half_from_float(0.1F), 0x2E66);
  EXPECT_EQ(half_from_float(65504), 0x7BFF);
  EXPECT_EQ(half_from_float(65520), 0x7C00);
  EXPECT_EQ(half_from_float(std::numeric_limits<float>::infinity()), 0x7C00);
  EXPECT_EQ(half_from_float(1.00048828125F), 0x3C00);  // half way: to the even one
  EXPECT_EQ(half_from_float(1.00146484375F), 0x3C02);
  EXPECT_EQ(half_from_float(0x1p-24F), 0x0001);
  EXPECT_EQ(half_from_float(0x1p-14F), 0x0400);
}

TEST(Npy, HasAHeaderOfWholeSixtyFours) {
  const std::vector<uint8_t> bytes = encode_npy_half(Plane<float>(3, 2, 1.0F));
  ASSERT_GT(bytes.size(), 64U);
  EXPECT_EQ((bytes.size() - 12) % 64, 0U);
  EXPECT_EQ(std::string(bytes.begin() + 1, bytes.begin() + 6), "NUMPY");
}

// One wall at the front, seen from the centre of the arc: distances along rays, and where each eye sees its edge.
TEST(Surround, EyesSeeAnEdgeApartByTheirDistance) {
  SceneDescription description = only(at(Shape::box, {5, 2.001, 1.6}, {5, 0.001, 1}));  // its left edge straight ahead
  Material& red = description.objects[0].material;
  red.dark = red.light = {0.5F, 0.01F, 0.01F};
  const SweepPath path;
  const double eyes = 0.2;
  const int width = 720;
  const Surround seen = take_surround(Scene(description), path, {.width = width, .eyes = eyes}, {}, {});
  ASSERT_EQ(seen.one_eye.width, width);
  ASSERT_EQ(seen.one_eye.height, width / 2);
  ASSERT_EQ(seen.two_eyes.height, width);
  EXPECT_NEAR(seen.distance.at(width / 2, width / 4), 2, 1e-3);
  EXPECT_TRUE(std::isinf(seen.distance.at(width / 4, width / 4)));
  const double pitch = 2 * std::numbers::pi / width;
  const auto edge = [&](const RgbImage& image, int row) {
    int x = width / 2 - 150;
    while (image.at(x, row).b > 60) ++x;
    return x;
  };
  const double apart_px = std::asin(eyes / 2 / 2) / pitch;
  EXPECT_NEAR(edge(seen.one_eye, width / 4), width / 2, 1);
  EXPECT_NEAR(edge(seen.two_eyes, width / 4), width / 2 + apart_px, 1) << "to the left eye further to the right";
  EXPECT_NEAR(edge(seen.two_eyes, width / 2 + width / 4), width / 2 - apart_px, 1);
  const SurroundOptions turned{.width = width, .heading_rad = std::numbers::pi / 4};
  EXPECT_NEAR(edge(take_surround(Scene(description), path, turned, {}, {}).one_eye, width / 4), width / 2 - width / 8,
              1);
  EXPECT_THROW(take_surround(Scene(description), path, {.width = 721}, {}, {}), std::logic_error);
}

}  // namespace
}  // namespace ldp
