#include "core/poses/tracks/track_triangulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "core/poses/adjust/depth_outliers.h"
#include "core/poses/tracks/triangulation.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

TEST(TriangulatePoint, FindsNearFarAndInfinitelyFarPoints) {
  for (const double w : {1.5, 0.3, 0.01, 0.0}) {
    const InversePoint truth{Eigen::Vector3d(0.3, -0.1, 1).normalized(), w};
    std::vector<Sighting> sightings;
    for (int i = -1; i <= 1; ++i) {
      const Eigen::Vector3d centre(0.2 * i, 0.05, -0.1 * i * i);
      const Eigen::Matrix3d camera_from_world = turn(2 * i, -8 * i, i);
      sightings.push_back({camera_from_world, centre, (camera_from_world * truth.seen_from(centre)).hnormalized()});
    }
    const auto point = triangulate_point(sightings);
    ASSERT_TRUE(point.has_value());
    EXPECT_NEAR(point->inverse_distance, w, 1e-9);
    EXPECT_LT((point->direction - truth.direction).norm(), 1e-9);
  }
}

TEST(TriangulatePoint, LeavesOutTheSightingThatDisagrees) {
  const InversePoint truth{Eigen::Vector3d::UnitZ(), 0.5};
  std::vector<Sighting> sightings;
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d centre(0.1 * i, 0, 0);
    sightings.push_back({Eigen::Matrix3d::Identity(), centre, truth.seen_from(centre).hnormalized()});
  }
  sightings[2].position.y() += 0.1;
  std::vector<bool> used;
  const auto point = triangulate_point_robustly(sightings, 0.01, used);
  ASSERT_TRUE(point.has_value());
  EXPECT_EQ(used, (std::vector<bool>{true, true, false, true, true}));
  EXPECT_NEAR(point->inverse_distance, 0.5, 1e-9);
}

TEST(NormalisedError, IsInfiniteForAPointInTheCamera) {
  const Sighting sighting{Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 1), Eigen::Vector2d::Zero()};
  EXPECT_NEAR(normalised_error({Eigen::Vector3d::UnitZ(), 0.9}, sighting), 0, 1e-12);
  EXPECT_TRUE(std::isinf(normalised_error({Eigen::Vector3d::UnitZ(), 0.999}, sighting)));
}

TEST(TriangulateInliers, LeavesOutATrackOfWhichOnlyHalfAgrees) {
  Bundle bundle = true_bundle(MotionModel::free);
  const auto track_of = [&](int point) {
    Track track;
    for (const BundleObservation& o : bundle.observations) {
      if (o.point == point && track.size() < 4) track.push_back({o.camera, -1, o.position_px});
    }
    return track;
  };
  std::vector<Track> tracks;
  for (int point = 0; tracks.size() < 3; ++point) {
    if (Track track = track_of(point); track.size() == 4) tracks.push_back(std::move(track));
  }
  tracks[1][0].position_px.y() += 40;  // three of four agree
  tracks[2][0].position_px.y() += 40, tracks[2][2].position_px.y() -= 60;
  const std::vector<Track> kept = triangulate_inliers(tracks, 3, false, bundle, Job{});
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].size(), 4U);
  EXPECT_EQ(kept[1].size(), 3U);
  EXPECT_EQ(bundle.points.size(), 2U);
}

// Points of a wall seen by the two cameras in the middle; the one amid them is at another inverse distance, and a third
// camera may see it.
std::vector<bool> depth_outliers_of_a_wall(double other, bool third) {
  Bundle bundle = true_bundle(MotionModel::free);
  bundle.points.clear();
  std::vector<Track> tracks;
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector3d direction =
        bundle.cameras[3].world_from_camera * Eigen::Vector3d(0.05 * (i % 5 - 2), 0.05 * (i / 5 - 2), 1).normalized();
    bundle.points.push_back({direction, i == 12 ? other : 0.2});
    Track track;
    for (int c = 3; c < (i == 12 && third ? 6 : 5); ++c) {
      const Projection p = project_point(bundle.cameras[static_cast<size_t>(c)], bundle.lens, bundle.points.back());
      track.push_back({c, -1, p.position_px});
    }
    tracks.push_back(std::move(track));
  }
  return depth_outliers(tracks, bundle, 5);
}

TEST(DepthOutliers, AreAsFarAsNothingAroundThem) {
  std::vector<bool> alone = depth_outliers_of_a_wall(0.6, false);
  EXPECT_TRUE(alone[12]);
  EXPECT_EQ(std::count(alone.begin(), alone.end(), true), 1);
  alone = depth_outliers_of_a_wall(0.21, false);
  EXPECT_EQ(std::count(alone.begin(), alone.end(), true), 0);
}

TEST(DepthOutliers, AreBelievedWhereAThirdPhotoSeesThem) { EXPECT_FALSE(depth_outliers_of_a_wall(0.6, true)[12]); }

TEST(DepthOutliers, BeyondInfinityAreNot) { EXPECT_TRUE(depth_outliers_of_a_wall(-0.09, true)[12]); }

TEST(DepthOutliers, AreNoneWhereTheCamerasAreWrong) {
  Bundle bundle = true_bundle(MotionModel::free);
  std::vector<Track> tracks;
  for (InversePoint& point : bundle.points) {
    tracks.push_back({{3, -1, Eigen::Vector2d::Zero()}, {4, -1, Eigen::Vector2d::Zero()}});
    point.inverse_distance = -0.5;
  }
  const std::vector<bool> alone = depth_outliers(tracks, bundle, 5);
  EXPECT_EQ(std::count(alone.begin(), alone.end(), true), 0);
}

}  // namespace
}  // namespace ldp::sfm
