#include "core/poses/refine/corner_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/poses/features/corners.h"
#include "core/poses/features/features.h"
#include "core/poses/refine/occupancy_grid.h"
#include "sim/scene/picture.h"
#include "sim/scene/scenes.h"
#include "sim/scene/sweep_path.h"

namespace ldp::sfm {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

GreyImage with_a_square(int left, int top, int size) {
  GreyImage picture(80, 60, 50);
  for (int y = top; y < top + size; ++y) {
    for (int x = left; x < left + size; ++x) picture.at(x, y) = 200;
  }
  return picture;
}

TEST(FindCorners, AreThoseOfASquareAndNotItsEdges) {
  const std::vector<Corner> corners = find_corners(with_a_square(30, 20, 20), 8);
  ASSERT_GE(corners.size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LE(std::min(std::abs(corners[i].x - 30), std::abs(corners[i].x - 49)), 3);
    EXPECT_LE(std::min(std::abs(corners[i].y - 20), std::abs(corners[i].y - 39)), 3);
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GT(std::abs(corners[i].x - corners[j].x) + std::abs(corners[i].y - corners[j].y), 10);
    }
  }
  for (const Corner& corner : corners) {  // along an edge all is the same
    EXPECT_FALSE(corner.x > 36 && corner.x < 43);
    EXPECT_FALSE(corner.y > 26 && corner.y < 33);
  }
}

TEST(FindCorners, AreNoneWhereAllChangesInOneDirection) {
  GreyImage picture(80, 60, 50);
  for (int y = 0; y < 60; ++y) {
    for (int x = 40; x < 80; ++x) picture.at(x, y) = 200;
  }
  EXPECT_THAT(find_corners(picture, 8), testing::IsEmpty());
}

TEST(FindCorners, KeepFromTheBorder) {
  EXPECT_THAT(find_corners(with_a_square(4, 4, 6), 14), testing::IsEmpty());
  EXPECT_THAT(find_corners(with_a_square(4, 4, 6), 4), testing::Not(testing::IsEmpty()));
}

TEST(OccupancyGrid, TellsWhatIsNearAnywhereInThePhoto) {
  OccupancyGrid occupied(100, 80, 7);
  occupied.add({-50, -40});
  occupied.add({50, 40});
  EXPECT_TRUE(occupied.near({-45.1, -40}));
  EXPECT_TRUE(occupied.near({46, 35}));
  EXPECT_FALSE(occupied.near({42.9, 40}));
  EXPECT_FALSE(occupied.near({0, 0}));
}

// Photos of a courtyard from cameras that are known, of which little has been followed: places in a grid.
struct KnownCameras {
  MatchedSweep sweep;
  Reconstruction known;
  std::vector<Plane<float>> depths;

  KnownCameras() {
    SweepPath path;
    path.frames = 6;
    path.arc_rad = 50 * kDegree;
    path.width = 400, path.height = 300;
    const Scene scene(make_scene("courtyard", 1));
    const std::vector<Camera> cameras = sweep_cameras(path);
    known.left_out.resize(cameras.size());
    known.bundle.lens.focal_px = cameras[0].intrinsics.fx;
    for (const Camera& camera : cameras) {
      Picture picture = take_picture(scene, camera, PictureOptions{}, Job{});
      sweep.pictures.push_back(make_grey_photo(picture.colour, 800));
      sweep.features.push_back({path.width, path.height, {}, {}});
      depths.push_back(std::move(picture.depth));
      const Eigen::Vector3d from_middle = camera.pose.centre - Eigen::Vector3d(0, 0, path.eye_height);
      known.bundle.cameras.push_back({camera.pose.world_from_camera, from_middle / path.radius});
    }
    for (Plane<float>& depth : depths) {
      for (float& d : depth.samples) d /= static_cast<float>(path.radius);
    }
    for (int y = 60; y < path.height; y += 60) {
      for (int x = 60; x < path.width; x += 60) add(2, {x - 0.5 * path.width, y - 0.5 * path.height});
    }
  }

  double depth(size_t frame, const Eigen::Vector2d& p) const {
    const Plane<float>& depth = depths[frame];
    const int x = static_cast<int>(std::floor(p.x() + 0.5 * depth.width));
    const int y = static_cast<int>(std::floor(p.y() + 0.5 * depth.height));
    return depth.contains(x, y) ? static_cast<double>(depth.at(x, y)) : 0;
  }

  // By which a point at z of what the frame shows at a place differs from that, or from what is within two pixels of
  // it (edges), where a third of the path is the baseline.
  double parallax_px(size_t frame, const Eigen::Vector2d& p, double z) const {
    const double baseline = (known.bundle.cameras[2].centre - known.bundle.cameras[0].centre).norm();
    double least = 1e9;
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x)
        least = std::min(least, std::abs(1 / z - 1 / depth(frame, p + Eigen::Vector2d(x, y))));
    }
    return known.bundle.lens.focal_px * baseline * least;
  }

  // What a frame shows at a place, as all frames see it.
  void add(size_t frame, const Eigen::Vector2d& p) {
    const Pose& pose = known.bundle.cameras[frame];
    const double w = 1 / depth(frame, p);
    const Eigen::Vector3d m =
        pose.world_from_camera * undistorted_ray(p, known.bundle.lens).homogeneous() + w * pose.centre;
    const InversePoint point{m.normalized(), w / m.norm()};
    Track track;
    for (size_t i = 0; i < depths.size(); ++i) {
      const Projection there = project_point(known.bundle.cameras[i], known.bundle.lens, point);
      if (there.in_front && depth(i, there.position_px) > 0)
        track.push_back({static_cast<int>(i), -1, there.position_px});
    }
    add_point(track, point, known.bundle);
    known.tracks.push_back(track);
  }

  Reconstruction gathered(int threads = 1) const {
    Job job;
    job.threads = threads;
    Reconstruction r = known;
    add_corner_tracks(sweep, job, r);
    return r;
  }
};

const KnownCameras& courtyard() {
  static const KnownCameras known;
  return known;
}

const Reconstruction& gathered() {
  static const Reconstruction r = courtyard().gathered();
  return r;
}

TEST(AddCornerTracks, AddsManyThatThreePhotosShowWhereTheyAre) {
  const KnownCameras& truth = courtyard();
  const Reconstruction& r = gathered();
  const size_t first = truth.known.tracks.size();
  ASSERT_GT(r.tracks.size(), first + 200);
  ASSERT_EQ(r.bundle.points.size(), r.tracks.size());
  int there = 0;
  for (size_t i = first; i < r.tracks.size(); ++i) {
    EXPECT_GE(r.tracks[i].size(), 3U);
    const Observation& o = r.tracks[i][r.tracks[i].size() / 2];
    const Pose& pose = r.bundle.cameras[static_cast<size_t>(o.frame)];
    const InversePoint& point = r.bundle.points[i];
    const double z = pose.world_from_camera.col(2).dot(point.seen_from(pose.centre)) / point.inverse_distance;
    there += truth.parallax_px(static_cast<size_t>(o.frame), o.position_px, z) < 1 ? 1 : 0;
  }
  EXPECT_GT(there, 0.9 * static_cast<double>(r.tracks.size() - first));
  for (size_t i = 0; i < first; ++i) EXPECT_EQ(r.bundle.points[i].direction, truth.known.bundle.points[i].direction);
}

TEST(AddCornerTracks, ObservationsAreOfTheirTracks) {
  const Reconstruction& r = gathered();
  std::vector<size_t> seen(r.tracks.size(), 0);
  for (const BundleObservation& o : r.bundle.observations) ++seen[static_cast<size_t>(o.point)];
  for (size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], r.tracks[i].size());
}

TEST(AddCornerTracks, AddsNothingTwice) {
  const Reconstruction& r = gathered();
  const size_t first = courtyard().known.tracks.size();
  const double near = courtyard().sweep.pixels(3);
  for (size_t i = first; i < r.tracks.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      for (const Observation& p : r.tracks[i]) {
        for (const Observation& q : r.tracks[j]) {
          ASSERT_FALSE(p.frame == q.frame && (p.position_px - q.position_px).norm() < near) << i << " and " << j;
        }
      }
    }
  }
}

TEST(AddCornerTracks, GivesTheSameAtAnyThreadCount) {
  const Reconstruction other = courtyard().gathered(4);
  ASSERT_EQ(other.tracks.size(), gathered().tracks.size());
  for (size_t i = 0; i < other.tracks.size(); ++i) {
    EXPECT_EQ(other.bundle.points[i].direction, gathered().bundle.points[i].direction);
    EXPECT_EQ(other.bundle.points[i].inverse_distance, gathered().bundle.points[i].inverse_distance);
  }
}

}  // namespace
}  // namespace ldp::sfm
