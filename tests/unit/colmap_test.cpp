#include "core/captures/colmap.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <sstream>

namespace ldp {
namespace {

Camera camera(const std::string& name, double turn, const Eigen::Vector3d& centre) {
  Intrinsics k{640, 480, 500, 510, 321, 239};
  k.k1 = 0.05, k.k2 = -0.02, k.p1 = 0.001;
  Camera c{name, k, {}};
  c.pose.world_from_camera = Eigen::AngleAxisd(turn, Eigen::Vector3d(0.2, 1, -0.1).normalized()).toRotationMatrix();
  c.pose.centre = centre;
  return c;
}

Eigen::Vector2d seen(const Camera& c, const Eigen::Vector3d& x) {
  return project(c.intrinsics, c.pose.world_from_camera.transpose() * (x - c.pose.centre));
}

struct Sweep {
  std::vector<Camera> cameras{camera("a b.jpg", 0.1, {0.1, 0.2, 0.3}), camera("c.jpg", -0.2, {-0.3, 0, 0.1})};
  std::vector<ScenePoint> points{{{0.5, 0.2, 4}, {0, 1}}, {{-0.4, -0.3, 6}, {1}}};
  std::vector<std::vector<Eigen::Vector2d>> sightings{
      {seen(cameras[0], points[0].position), seen(cameras[1], points[0].position)},
      {seen(cameras[1], points[1].position) + Eigen::Vector2d(0.6, 0.8)}};
};

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] != '#') result.push_back(line);
  }
  return result;
}

// By COLMAP's own description: x_camera = R(q) x + t, then the OPENCV model.
TEST(Colmap, AStrangerProjectsThePointsToWhereTheyWereSeen) {
  const Sweep sweep;
  const ColmapText text = colmap_text({sweep.cameras, sweep.points, sweep.sightings, {}});
  std::istringstream lens(lines(text.cameras).at(0));
  int id = 0, width = 0, height = 0;
  std::string model;
  double fx = 0, fy = 0, cx = 0, cy = 0, k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  lens >> id >> model >> width >> height >> fx >> fy >> cx >> cy >> k1 >> k2 >> p1 >> p2;
  EXPECT_EQ(model, "OPENCV");
  EXPECT_EQ(std::pair(width, height), std::pair(640, 480));
  const std::vector<std::string> images = lines(text.images);
  ASSERT_EQ(images.size(), 4U);
  for (const size_t i : {0U, 1U}) {
    std::istringstream image(images[2 * i]), positions(images[2 * i + 1]);
    int image_id = 0;
    double w = 0, x = 0, y = 0, z = 0;
    Eigen::Vector3d t;
    image >> image_id >> w >> x >> y >> z >> t[0] >> t[1] >> t[2];
    Eigen::Vector2d position;
    int point = 0;
    ASSERT_TRUE(positions >> position[0] >> position[1] >> point);
    ASSERT_EQ(point, 1);
    const Eigen::Vector3d p = Eigen::Quaterniond(w, x, y, z) * sweep.points[0].position + t;
    const double u = p.x() / p.z(), v = p.y() / p.z(), r2 = u * u + v * v, radial = 1 + k1 * r2 + k2 * r2 * r2;
    EXPECT_NEAR(fx * (u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u)) + cx, position.x(), 1e-9);
    EXPECT_NEAR(fy * (v * radial + p1 * (r2 + 2 * v * v) + 2 * p2 * u * v) + cy, position.y(), 1e-9);
  }
}

TEST(Colmap, TracksPointAtTheirPlaceInEveryImage) {
  const Sweep sweep;
  const std::vector<std::array<uint8_t, 3>> colours{{1, 2, 3}, {4, 5, 255}};
  const ColmapText text = colmap_text({sweep.cameras, sweep.points, sweep.sightings, colours});
  const std::vector<std::string> points = lines(text.points);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_TRUE(points[0].ends_with(" 1 0 2 0")) << points[0];
  EXPECT_TRUE(points[1].ends_with(" 2 1")) << points[1];
  std::istringstream second(points[1]);
  int id = 0, r = 0, g = 0, b = 0;
  double x = 0, y = 0, z = 0, error = 0;
  second >> id >> x >> y >> z >> r >> g >> b >> error;
  EXPECT_EQ(b, 255);
  EXPECT_EQ(x, -0.4);
  EXPECT_NEAR(error, 1, 1e-9);
}

TEST(Colmap, CamerasOfOneLensShareIt) {
  Sweep sweep;
  EXPECT_EQ(lines(colmap_text({sweep.cameras, {}, {}, {}}).cameras).size(), 1U);
  sweep.cameras[1].intrinsics.fx += 1;
  EXPECT_EQ(lines(colmap_text({sweep.cameras, {}, {}, {}}).cameras).size(), 2U);
}

TEST(Colmap, RefusesPartsThatDoNotFit) {
  Sweep sweep;
  sweep.sightings[0].pop_back();
  EXPECT_THROW(colmap_text({sweep.cameras, sweep.points, sweep.sightings, {}}), std::logic_error);
}

}  // namespace
}  // namespace ldp
