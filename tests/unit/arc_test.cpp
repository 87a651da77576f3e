#include "core/arc/arc.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "core/base/job.h"

namespace ldp {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRounding = 1e-7;  // the arc is rounded to 24 bits

struct Hand {
  double radius = 0.7, begin_deg = -90, end_deg = 90, pitch_deg = 0;
  int frames = 20;
  double place_jitter = 0, turn_jitter_deg = 0;
};

const Eigen::Vector3d kCentre(3, -2, 1.6);

Camera outward_camera(const Eigen::Vector3d& centre, double azimuth_deg, double pitch_deg) {
  const double a = azimuth_deg * kDegree, p = pitch_deg * kDegree;
  const Eigen::Vector3d forward(std::cos(a) * std::cos(p), std::sin(a) * std::cos(p), std::sin(p));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Camera camera{"", {800, 600, 700, 700, 400, 300}, {}};
  camera.pose.world_from_camera << right, forward.cross(right), forward;
  camera.pose.centre = centre;
  return camera;
}

std::vector<Camera> sweep(const Hand& hand) {
  std::mt19937 random(7);
  const auto noise = [&](double sigma) {
    return sigma * (static_cast<double>(random()) / 2147483648.0 - 1) * std::sqrt(3.0);
  };
  std::vector<Camera> cameras;
  for (int i = 0; i < hand.frames; ++i) {
    const double at = hand.begin_deg + (hand.end_deg - hand.begin_deg) * i / (hand.frames - 1), a = at * kDegree;
    const double x = noise(hand.place_jitter), y = noise(hand.place_jitter), z = noise(hand.place_jitter);
    const Eigen::Vector3d centre =
        kCentre + hand.radius * Eigen::Vector3d(std::cos(a), std::sin(a), 0) + Eigen::Vector3d(x, y, z);
    const double yaw = noise(hand.turn_jitter_deg), pitch = noise(hand.turn_jitter_deg);
    cameras.push_back(outward_camera(centre, at + yaw, hand.pitch_deg + pitch));
  }
  return cameras;
}

TEST(FitArc, FindsAPerfectHalfCircleExactly) {
  const ArcFit fit = fit_arc(sweep({}));
  EXPECT_LT((fit.arc.centre - kCentre).norm(), kRounding);
  EXPECT_NEAR(fit.arc.radius, 0.7, kRounding);
  EXPECT_GT(fit.arc.axis().z(), 1 - kRounding);
  EXPECT_NEAR(fit.arc.theta_end - fit.arc.theta_begin, std::numbers::pi, kRounding);
  EXPECT_FALSE(fit.arc.closed);
  EXPECT_FALSE(fit.straight);
}

TEST(FitArc, ArcAxesAreARightHandedFrame) {
  const Eigen::Matrix3d axes = fit_arc(sweep({})).arc.world_from_arc;
  EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(axes.determinant(), 1, 1e-12);
}

TEST(FitArc, OutwardDirectionsPointAtTheCamerasPlaces) {
  const std::vector<Camera> cameras = sweep({});
  const Arc arc = fit_arc(cameras).arc;
  EXPECT_LT((arc.centre + arc.radius * arc.outward(arc.theta_begin) - cameras.front().pose.centre).norm(), kRounding);
  EXPECT_LT((arc.centre + arc.radius * arc.outward(arc.theta_end) - cameras.back().pose.centre).norm(), kRounding);
}

TEST(FitArc, BearsAnUnsteadyHand) {
  Hand hand;
  hand.place_jitter = 0.015, hand.turn_jitter_deg = 1.2;
  const ArcFit fit = fit_arc(sweep(hand));
  EXPECT_NEAR(fit.arc.radius, 0.7, 0.02);
  EXPECT_LT((fit.arc.centre - kCentre).norm(), 0.03);
  EXPECT_GT(fit.arc.axis().z(), std::cos(2 * kDegree));
}

TEST(FitArc, OneWildCameraDoesNotMoveIt) {
  std::vector<Camera> cameras = sweep({});
  cameras[5].pose.centre += Eigen::Vector3d(0.5, 0.2, 0.4);
  const ArcFit fit = fit_arc(cameras);
  EXPECT_NEAR(fit.arc.radius, 0.7, 0.01);
  EXPECT_GT(std::abs(fit.height_residuals[5]), 0.3);
}

TEST(FitArc, AShortArcTakesItsRadiusFromWhereTheCamerasLook) {
  Hand hand;
  hand.begin_deg = -20, hand.end_deg = 20, hand.place_jitter = 0.01, hand.turn_jitter_deg = 1;
  const ArcFit fit = fit_arc(sweep(hand));
  EXPECT_FALSE(fit.straight);
  EXPECT_NEAR(fit.arc.radius, 0.7, 0.15);
}

TEST(FitArc, AFullTurnClosesAlthoughItsCamerasLookUp) {
  Hand hand;
  hand.begin_deg = -180, hand.end_deg = 168, hand.frames = 30, hand.pitch_deg = 15;
  const ArcFit fit = fit_arc(sweep(hand));
  EXPECT_TRUE(fit.arc.closed);
  EXPECT_NEAR(fit.arc.theta_end - fit.arc.theta_begin, 2 * std::numbers::pi, 1e-12);
  EXPECT_GT(fit.arc.axis().z(), 1 - 1e-6);
}

TEST(FitArc, DoesNotDependOnTheOrderOfTheCameras) {
  std::vector<Camera> cameras = sweep({});
  const Arc before = fit_arc(cameras).arc;
  std::shuffle(cameras.begin(), cameras.end(), std::mt19937(3));
  const Arc after = fit_arc(cameras).arc;
  EXPECT_NEAR(before.radius, after.radius, kRounding);
  EXPECT_NEAR(before.theta_end - before.theta_begin, after.theta_end - after.theta_begin, kRounding);
}

TEST(FitArc, AStraightPathIsSaidToBeStraightAndGetsARadiusOfOneAndAHalfPathLengths) {
  std::vector<Camera> cameras;
  for (int i = 0; i < 10; ++i) cameras.push_back(outward_camera({0.1 * i, 0, 1.6}, 90, 0));
  const ArcFit fit = fit_arc(cameras);
  EXPECT_TRUE(fit.straight);
  EXPECT_NEAR(fit.arc.radius, 1.5 * 0.9, 1e-6);
  EXPECT_GT(fit.arc.outward(0.5 * (fit.arc.theta_begin + fit.arc.theta_end)).y(), 0.99);
}

TEST(FitArc, APathAlongTheLineOfSightIsSeenFromItsRearEnd) {
  std::vector<Camera> cameras;
  for (int i = 0; i < 10; ++i) cameras.push_back(outward_camera({0.1 * i, 0, 1.6}, 2 * i - 9, 0));
  const ArcFit fit = fit_arc(cameras);
  EXPECT_TRUE(fit.forward);
  EXPECT_EQ(fit.arc.radius, 0);
  EXPECT_NEAR(fit.arc.centre.x(), 0, 0.02);
  EXPECT_NEAR(fit.arc.theta_end - fit.arc.theta_begin, 18 * kDegree, 0.001);
  EXPECT_GT(fit.arc.outward(0.5 * (fit.arc.theta_begin + fit.arc.theta_end)).x(), 0.99);
  const PanoramaGrid grid = lay_grid(fit.arc, cameras, {}, {});
  const double field = 2 * std::atan(400.0 / 700) + 18 * kDegree;
  EXPECT_NEAR(grid.width * grid.theta_pitch, field, 0.05 * field) << "no more than is seen";
}

TEST(FitArc, CamerasThatOnlyTurnGetACircleOfRadiusZero) {
  Hand hand;
  hand.radius = 0;
  const ArcFit fit = fit_arc(sweep(hand));
  EXPECT_EQ(fit.arc.radius, 0);
  EXPECT_NEAR(fit.arc.theta_end - fit.arc.theta_begin, std::numbers::pi, kRounding);
}

std::vector<Camera> on_their_side(std::vector<Camera> cameras) {
  for (Camera& camera : cameras) {
    Eigen::Matrix3d& axes = camera.pose.world_from_camera;
    axes = (Eigen::Matrix3d() << axes.col(1), -axes.col(0), axes.col(2)).finished();
  }
  return cameras;
}

TEST(Sideways, IsToldOfSweepsThatGoUpOrDownInThePhotosAlone) {
  Hand arc, unsteady, all_round, on_the_spot, back;
  arc.begin_deg = -20, arc.end_deg = 20;
  unsteady.place_jitter = 0.02, unsteady.turn_jitter_deg = 4;
  all_round.end_deg = 250, all_round.pitch_deg = 20;
  on_the_spot.radius = 0;
  back.begin_deg = 90, back.end_deg = -90;
  std::vector<Camera> straight = sweep({}), ahead = straight;
  for (size_t i = 0; i < straight.size(); ++i) {
    straight[i] = outward_camera(Eigen::Vector3d(0, 0.1 * static_cast<double>(i), 0), i % 2 == 0 ? 3 : -3, 0);
    ahead[i] = outward_camera(Eigen::Vector3d(0.1 * static_cast<double>(i), 0, 0), 0, i % 2 == 0 ? 3 : -3);
    ahead[i].pose.centre.z() += 0.01 * static_cast<double>(i);
  }
  for (const auto& cameras :
       {sweep(arc), sweep(unsteady), sweep(all_round), sweep(on_the_spot), sweep(back), straight}) {
    EXPECT_EQ(sideways(cameras), "");
    EXPECT_NE(sideways(on_their_side(cameras)).find("a turn by 90 or by 270 degrees"), std::string::npos);
  }
  EXPECT_EQ(sideways(ahead), "");
  EXPECT_EQ(sideways(on_their_side(ahead)), "");
}

// Who walks with the camera held down, or downstairs, moves down in the photos without turning so.
TEST(Sideways, OnlyWhoTurnsUpOrDownNods) {
  Hand on_the_spot;
  on_the_spot.radius = 0;
  std::vector<Camera> downstairs = sweep({});
  for (size_t i = 0; i < downstairs.size(); ++i)
    downstairs[i] = outward_camera(static_cast<double>(i) * Eigen::Vector3d(0.1, 0, -0.08), 0, 0);
  for (const auto& cameras : {sweep({}), sweep(on_the_spot)}) {
    EXPECT_FALSE(nods(cameras));
    EXPECT_TRUE(nods(on_their_side(cameras)));
  }
  EXPECT_FALSE(nods(downstairs));
  EXPECT_NE(sideways(downstairs), "");
}

TEST(FitArc, RefusesTwoCamerasAndPosesThatAreNoNumbers) {
  std::vector<Camera> cameras = sweep({});
  EXPECT_THROW(fit_arc({cameras[0], cameras[1]}), Impossible);
  cameras[3].pose.centre.x() = std::nan("");
  EXPECT_THROW(fit_arc(cameras), std::runtime_error);
}

std::vector<ScenePoint> shell(double nearest, double farthest) {
  std::vector<ScenePoint> points;
  for (int i = 0; i < 500; ++i) {
    const double a = (-100 + 0.4 * i) * kDegree, distance = 0.7 + nearest + (farthest - nearest) * (i % 50) / 49;
    points.push_back({kCentre + distance * Eigen::Vector3d(std::cos(a), std::sin(a), 0), {0, 1}});
  }
  return points;
}

TEST(LayGrid, EveryPixelOfEveryCameraLiesInside) {
  const std::vector<Camera> cameras = sweep({});
  const PanoramaGrid grid = lay_grid(fit_arc(cameras).arc, cameras, shell(1, 10), GridOptions{});
  EXPECT_FALSE(grid.wraps);
  for (const Camera& camera : cameras) {
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(0, 0), {800, 0}, {400, 0}, {0, 600}, {800, 600}, {0, 300}, {800, 300}}) {
      for (const double depth : {1.2, 3.0, 9.0}) {
        const Eigen::Vector3d ray = camera.pose.world_from_camera * unproject(camera.intrinsics, pixel);
        const PanoramaPosition p = locate(grid, camera.pose.centre + depth * ray);
        EXPECT_GE(p.x_px, -1e-6);
        EXPECT_LE(p.x_px, grid.width + 1e-6);
        EXPECT_GE(p.y_px, -1.0);
        EXPECT_LE(p.y_px, grid.height + 1.0);
      }
    }
  }
}

TEST(LayGrid, PitchIsThePhotosPixelAndFollowsTheOption) {
  const std::vector<Camera> cameras = sweep({});
  const Arc arc = fit_arc(cameras).arc;
  GridOptions options;
  EXPECT_NEAR(lay_grid(arc, cameras, {}, options).theta_pitch, 1 / 700.0, 1e-15);
  options.pitch_px = 2;
  EXPECT_NEAR(lay_grid(arc, cameras, {}, options).v_pitch, 2 / 700.0, 1e-15);
}

TEST(LayGrid, AClosedSweepWrapsInWholeColumns) {
  Hand hand;
  hand.begin_deg = -180, hand.end_deg = 168, hand.frames = 30;
  const std::vector<Camera> cameras = sweep(hand);
  const PanoramaGrid grid = lay_grid(fit_arc(cameras).arc, cameras, shell(1, 10), GridOptions{});
  EXPECT_TRUE(grid.wraps);
  EXPECT_DOUBLE_EQ(grid.theta_pitch * grid.width, 2 * std::numbers::pi);
}

TEST(LayGrid, DepthsComeFromThePointsAndFarSceneryIsAtInfinity) {
  const std::vector<Camera> cameras = sweep({});
  const Arc arc = fit_arc(cameras).arc;
  const PanoramaGrid room = lay_grid(arc, cameras, shell(1, 4), GridOptions{});
  EXPECT_NEAR(1 / room.w_near, 1, 0.25);
  EXPECT_NEAR(1 / room.w_far, 4, 1);
  EXPECT_EQ(lay_grid(arc, cameras, shell(1, 40), GridOptions{}).w_far, 0);
}

TEST(LayGrid, AFewPointsOfThreeCamerasAreSomethingThereFewerOrUnsureOnesAreNot) {
  const std::vector<Camera> cameras = sweep({});
  const Arc arc = fit_arc(cameras).arc;
  const auto with = [&](int count, double depth, const std::vector<int>& seen_by) {
    std::vector<ScenePoint> points = shell(2, 4);
    for (int i = 0; i < count; ++i) points.push_back({kCentre + Eigen::Vector3d(0.7 + depth, 0.01 * i, 0), seen_by});
    return lay_grid(arc, cameras, points, {});
  };
  const PanoramaGrid without = with(0, 0, {});
  EXPECT_NEAR(1 / without.w_near, 2, 0.5);
  EXPECT_NEAR(1 / with(8, 1, {0, 1, 2}).w_near, 1, 0.2);
  EXPECT_NEAR(1 / with(7, 1, {0, 1, 2}).w_near, 1 / without.w_near, 0.1);  // a point more moves the percentile
  EXPECT_NEAR(1 / with(8, 1, {0, 1}).w_near, 1 / without.w_near, 0.1);
  EXPECT_NEAR(1 / without.w_far, 4, 1);
  EXPECT_NEAR(1 / with(8, 7, {0, 1, 2}).w_far, 7 * 1.15, 0.1);
  EXPECT_NEAR(1 / with(7, 7, {0, 1, 2}).w_far, 1 / without.w_far, 0.1);
  EXPECT_NEAR(1 / with(8, 7, {0, 1}).w_far, 1 / without.w_far, 0.1);
}

TEST(LayGrid, WhatPhotosMatchNearerWidensTheRangeAsFarAsTheHandKeptToTheArc) {
  const std::vector<Camera> cameras = sweep({});
  const Arc arc = fit_arc(cameras).arc;
  GridOptions options;
  const double points_tell = lay_grid(arc, cameras, shell(1, 4), options).w_near;
  options.matched_near = 1.3 * points_tell;
  EXPECT_NEAR(lay_grid(arc, cameras, shell(1, 4), options).w_near, 1.3 * points_tell, 0.01 * points_tell);
  options.matched_near = 0.7 * points_tell;
  EXPECT_EQ(lay_grid(arc, cameras, shell(1, 4), options).w_near, points_tell);
  options.near_depth = 2;
  EXPECT_EQ(lay_grid(arc, cameras, shell(1, 4), options).w_near, 0.5);
}

TEST(LayGrid, GivenDepthsRule) {
  const std::vector<Camera> cameras = sweep({});
  GridOptions options;
  options.near_depth = 2, options.far_depth = 8;
  const PanoramaGrid grid = lay_grid(fit_arc(cameras).arc, cameras, shell(1, 4), options);
  EXPECT_DOUBLE_EQ(grid.w_near, 0.5);
  EXPECT_DOUBLE_EQ(grid.w_far, 0.125);
  options.near_depth = 9;
  EXPECT_THROW(lay_grid(grid.arc, cameras, {}, options), std::logic_error);
}

TEST(ColumnsOfColour, AreTwoWhereMostPointsLieWithinOneRadiusOfTheArc) {
  const std::vector<Camera> cameras = sweep({});
  const Arc arc = fit_arc(cameras).arc;
  const auto columns = [&](double depth_in_radii, Rays rays) {
    GridOptions options;
    options.rays = rays;
    const std::vector<ScenePoint> points = shell(depth_in_radii * arc.radius, depth_in_radii * arc.radius);
    return columns_of_colour(lay_grid(arc, cameras, points, options), cameras, points);
  };
  EXPECT_EQ(columns(1.1, Rays::pushbroom), 1);
  EXPECT_EQ(columns(0.8, Rays::pushbroom), 2);
  EXPECT_EQ(columns(0.3, Rays::pushbroom), 2);  // at most
  EXPECT_EQ(columns(0.3, Rays::central), 1);    // those rays start where the photos were taken, nearly
  const PanoramaGrid grid = lay_grid(arc, cameras, {}, GridOptions{});
  EXPECT_EQ(columns_of_colour(grid, cameras, {}), 1);
  const std::vector<ScenePoint> close = shell(0.2, 0.2);
  EXPECT_EQ(columns_of_colour(grid, cameras, close), 2);
  EXPECT_EQ(columns_of_colour(grid, {cameras[0], cameras[1]}, close), 1);  // they have not as many columns
  PanoramaGrid tall = grid;
  tall.height *= 3;
  EXPECT_EQ(columns_of_colour(tall, cameras, close), 1);  // nor these as many pixels
  PanoramaGrid wide = grid;
  wide.width = 32768, wide.height = 1;
  EXPECT_EQ(columns_of_colour(wide, std::vector<Camera>(100, cameras[0]), close), 1);  // nor a file as many columns
  wide.width = 32767;
  EXPECT_EQ(columns_of_colour(wide, std::vector<Camera>(100, cameras[0]), close), 2);
}

TEST(FinerColumns, CoverTheSamePanorama) {
  const std::vector<Camera> cameras = sweep({});
  const PanoramaGrid grid = lay_grid(fit_arc(cameras).arc, cameras, shell(1, 10), GridOptions{});
  const PanoramaGrid finer = with_finer_columns(grid, 2);
  EXPECT_EQ(finer.width, 2 * grid.width);
  EXPECT_NEAR(finer.theta(finer.width), grid.theta(grid.width), 1e-12);
  EXPECT_EQ(finer.height, grid.height);
}

}  // namespace
}  // namespace ldp
