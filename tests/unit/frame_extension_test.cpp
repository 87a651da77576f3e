#include "core/view/mesh/frame_extension.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/view/mesh/mesh_strips.h"

namespace ldp::view {
namespace {

constexpr int kWidth = 200, kHeight = 100;
constexpr uint16_t kPost = 3000, kWall = 0;  // disparities

// Rays of a central panorama from v = 0.5 above to 0.5 below.
LayeredPanorama seen_by_two_photos(bool wraps) {
  LayeredPanorama panorama;
  PanoramaGrid& grid = panorama.grid;
  grid.arc.radius = 1;
  grid.width = kWidth, grid.height = kHeight;
  grid.wraps = wraps;
  grid.theta_pitch = wraps ? 2 * std::numbers::pi / kWidth : 0.01;
  grid.theta_left = 0.5 * kWidth * grid.theta_pitch;
  grid.v_pitch = 0.01, grid.v_top = 0.5;
  grid.w_near = 1;
  panorama.limits = {0.2, 1, 0};
  return panorama;
}

// A camera on the arc that looks along the middle of a column, over rows 30 to 70 of what is far.
Camera photo(const PanoramaGrid& grid, double column) {
  Camera camera;
  camera.intrinsics = {120, 60, 100, 100, 60, 30};
  const double theta = grid.theta(column + 0.5);
  const Eigen::Vector3d forward = grid.arc.outward(theta), down = -grid.arc.axis();
  camera.pose.world_from_camera << down.cross(forward), down, forward;
  camera.pose.centre = grid.origin(theta);
  return camera;
}

PreparedLayer wall(const LayeredPanorama& panorama) {
  return {Plane<float>(kWidth, kHeight, CodedDepths(panorama.grid).w(kWall)), Plane<Rgba>(kWidth, kHeight, 0xFF000000U),
          Plane<uint16_t>(kWidth, kHeight, kWall), Plane<uint8_t>(kWidth, kHeight, 0)};
}

void put_post(const LayeredPanorama& panorama, int x, int y0, int y1, PreparedLayer& front) {
  for (int y = y0; y < y1; ++y) {
    front.w.at(x, y) = CodedDepths(panorama.grid).w(kPost);
    front.code.at(x, y) = kPost;
  }
}

std::vector<SparseColumns> extended(const LayeredPanorama& panorama, const PreparedLayer& front) {
  return extend_beyond_frames(front, CodedDepths(panorama.grid), panorama, 0.01F);
}

TEST(FrameExtension, HoldsNoMoreThanTheRowsOfColumnsThatGoOn) {
  LayeredPanorama panorama = seen_by_two_photos(false);
  panorama.cameras = {photo(panorama.grid, 100), photo(panorama.grid, 101)};
  PreparedLayer front = wall(panorama);
  put_post(panorama, 100, 20, 60, front);
  const std::vector<SparseColumns> made = extended(panorama, front);
  ASSERT_EQ(made.size(), 1U);
  const auto [begin, end] = made[0].rows();
  EXPECT_EQ(end, 21);  // from the post's own last row on
  EXPECT_LT(begin, 20);
  EXPECT_TRUE(made[0].any(100, 101, begin, end));
  EXPECT_FALSE(made[0].any(0, 100, begin, end));
  EXPECT_FALSE(made[0].any(101, kWidth, begin, end));
  EXPECT_EQ(made[0].at(100, 19).w, front.w.at(100, 20));
  EXPECT_EQ(made[0].at(101, 19).w, kAbsent);
}

// The lower part, which no photo shows, is carried by what stands beside it, not by the upper one, which two show.
TEST(FrameExtension, NoPartOfAColumnWitnessesForAnother) {
  LayeredPanorama panorama = seen_by_two_photos(false);
  panorama.cameras = {photo(panorama.grid, 100), photo(panorama.grid, 101)};
  PreparedLayer front = wall(panorama);
  for (const int x : {100, 101}) {
    put_post(panorama, x, 20, 60, front);
    put_post(panorama, x, 92, 96, front);
  }
  const std::vector<SparseColumns> made = extended(panorama, front);
  ASSERT_FALSE(made.empty());
  for (const int x : {100, 101}) {
    EXPECT_GT(made[0].at(x, 19).w, 0);
    EXPECT_EQ(made[0].at(x, 91).w, kAbsent) << x;
  }
}

// Posts of one row of columns, on a wall that is far.
Layer posts(const PanoramaGrid& grid, const std::vector<int>& columns) {
  DisparityMap disparity(grid.width, grid.height, kWall);
  for (const int x : columns)
    for (int y = 20; y < 60; ++y) disparity.at(x, y) = kPost;
  Layer layer;
  layer.coverage = Plane<uint8_t>(grid.width, grid.height, 1);
  layer.colour = RgbImage(grid.width, grid.height);
  layer.depth = encode_depth(disparity, 8);
  return layer;
}

// Whether the strips' mesh has a vertex of a post above the posts in a column.
bool goes_on(const MeshStrips& strips, const std::vector<size_t>& places, int column) {
  constexpr int kLayers = 1, kUnderlay = 1, kAll = 8;
  const float post = CodedDepths(strips.grid()).w(kPost);
  const std::vector<const MeshTile*> tiles = strips.tiles(places, kAll);
  return std::any_of(tiles.begin(), tiles.end(), [&](const MeshTile* tile) {
    return tile->layer >= kLayers + kUnderlay &&
           std::any_of(tile->torn_vertices.begin(), tile->torn_vertices.end(), [&](const TornVertex& vertex) {
             return tile->x0 + vertex.x_in_tile == column && std::abs(vertex.w - post) < 0.01F;
           });
  });
}

// Both posts, to the left and to the right of the seam, are shown by two photos, what is between them by none.
TEST(FrameExtension, WitnessesStandAcrossTheSeamAndBordersOfStrips) {
  LayeredPanorama panorama = seen_by_two_photos(true);
  for (const double column : {-50.0, -49.9, 50.0, 50.1}) panorama.cameras.push_back(photo(panorama.grid, column));
  for (Camera& camera : panorama.cameras) camera.intrinsics.cx = 30, camera.intrinsics.width = 60;
  panorama.layers = {posts(panorama.grid, {kWidth - 50, 0, 50, 116})};
  MeshStrips strips(panorama, 1, BeyondFrames::surfaces);
  strips.make_all({});
  std::vector<size_t> all;
  for (size_t i = 0; i < (kWidth + kTilePx - 1) / kTilePx; ++i) all.push_back(i);
  for (const int column : {50, kWidth - 50, 0, kWidth}) EXPECT_TRUE(goes_on(strips, all, column)) << column;
  EXPECT_FALSE(goes_on(strips, all, 116));  // too far from the post at 50
}

}  // namespace
}  // namespace ldp::view
