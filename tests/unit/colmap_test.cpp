#include "core/captures/colmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/captures/colmap_model.h"

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

void expect_same(const std::vector<Camera>& found, const std::vector<Camera>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].name, expected[i].name);
    EXPECT_LT((found[i].pose.world_from_camera - expected[i].pose.world_from_camera).norm(), 1e-14);
    EXPECT_LT((found[i].pose.centre - expected[i].pose.centre).norm(), 1e-14);
    const Intrinsics &a = found[i].intrinsics, &b = expected[i].intrinsics;
    EXPECT_EQ(std::tuple(a.width, a.height, a.fx, a.fy, a.cx, a.cy, a.k1, a.k2, a.p1, a.p2),
              std::tuple(b.width, b.height, b.fx, b.fy, b.cx, b.cy, b.k1, b.k2, b.p1, b.p2));
  }
}

// By COLMAP's description of its binary files.
class BinaryFile {
 public:
  template <typename Number>
  BinaryFile& put(Number value) {
    const auto bits = std::bit_cast<std::array<uint8_t, sizeof(Number)>>(value);  // these tests run on little-endian
    bytes.insert(bytes.end(), bits.begin(), bits.end());
    return *this;
  }
  BinaryFile& put_name(const std::string& name) {
    bytes.insert(bytes.end(), name.begin(), name.end());
    bytes.push_back(0);
    return *this;
  }
  std::vector<uint8_t> bytes;
};

struct BinaryModel {
  BinaryFile cameras, images;
};

BinaryModel binary(const std::vector<Camera>& cameras) {
  BinaryModel model;
  model.cameras.put(uint64_t{1}).put(int32_t{7}).put(int32_t{4}).put(uint64_t{640}).put(uint64_t{480});
  const Intrinsics& k = cameras[0].intrinsics;
  for (const double value : {k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2}) model.cameras.put(value);
  model.images.put(static_cast<uint64_t>(cameras.size()));
  for (const Camera& camera : cameras) {
    const Eigen::Matrix3d r = camera.pose.world_from_camera.transpose();
    const Eigen::Quaterniond q(r);
    const Eigen::Vector3d t = -r * camera.pose.centre;
    model.images.put(int32_t{3});
    for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) model.images.put(value);
    model.images.put(int32_t{7}).put_name("photos/" + camera.name).put(uint64_t{2});
    for (int i = 0; i < 2; ++i) model.images.put(1.5).put(2.5).put(int64_t{-1});
  }
  return model;
}

TEST(ColmapModel, ReadsTheTextThatIsWritten) {
  const Sweep sweep;
  const ColmapText text = colmap_text({sweep.cameras, sweep.points, sweep.sightings, {}});
  expect_same(parse_colmap_text(text.cameras, text.images), sweep.cameras);
  const ColmapText without_points = colmap_text({sweep.cameras, {}, {}, {}});  // the second line of each image is empty
  expect_same(parse_colmap_text(without_points.cameras, without_points.images), sweep.cameras);
}

TEST(ColmapModel, ReadsBinaryFilesAsCOLMAPDescribesThem) {
  const Sweep sweep;
  const BinaryModel model = binary(sweep.cameras);
  expect_same(parse_colmap_binary(model.cameras.bytes, model.images.bytes), sweep.cameras);
}

TEST(ColmapModel, KnowsTheSimplerLenses) {
  const std::string image = "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
  const auto lens = [&](const std::string& line) {
    return parse_colmap_text("# a comment\n1 " + line + "\n", image).at(0).intrinsics;
  };
  EXPECT_EQ(lens("SIMPLE_PINHOLE 640 480 500 320 240").fy, 500);
  EXPECT_EQ(lens("PINHOLE 640 480 500 510 320 240").cy, 240);
  EXPECT_EQ(lens("SIMPLE_RADIAL 640 480 500 320 240 0.1").k1, 0.1);
  EXPECT_EQ(lens("RADIAL 640 480 500 320 240 0.1 -0.2").k2, -0.2);
  EXPECT_EQ(lens("OPENCV 640 480 500 510 320 240 0.1 -0.2 1e-3 2e-3").p2, 2e-3);
}

std::string refusal_of(const std::string& cameras, const std::string& images) {
  try {
    parse_colmap_text(cameras, images);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

TEST(ColmapModel, RefusesWhatItCannotMeanByItsPlace) {
  using testing::HasSubstr;
  const std::string lens = "1 PINHOLE 640 480 500 510 320 240\n", image = "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
  EXPECT_EQ(refusal_of(lens, image), "none");
  EXPECT_THAT(refusal_of("#\n1 OPENCV_FISHEYE 640 480 1 1 1 1 0 0 0 0\n", image),
              HasSubstr("cameras.txt line 2: camera model OPENCV_FISHEYE is not supported"));
  EXPECT_THAT(refusal_of("1 PINHOLE 640 480 500 x 320 240\n", image), HasSubstr("line 1: x is not a number"));
  EXPECT_THAT(refusal_of("1 PINHOLE 640 480 500\n", image), HasSubstr("line 1: ends early"));
  EXPECT_THAT(refusal_of("1 PINHOLE 640 0 500 510 320 240\n", image), HasSubstr("sides must be"));
  EXPECT_THAT(refusal_of("1 PINHOLE 640 480 500 -1 320 240\n", image), HasSubstr("focal lengths must be positive"));
  EXPECT_THAT(refusal_of("1 PINHOLE 640 480 500 nan 320 240\n", image), HasSubstr("finite"));
  EXPECT_EQ(refusal_of("1 PINHOLE 640 480 2621440 510 320 240\n", image), "none") << "4096 times 640";
  for (const char* const lengths : {"2621441 510 320 240", "500 510 320 -1e9"})
    EXPECT_THAT(refusal_of(std::string("1 PINHOLE 640 480 ") + lengths + "\n", image),
                HasSubstr("cameras.txt line 1: focal lengths and principal point must be at most 4096 times"));
  EXPECT_THAT(refusal_of("1 RADIAL 640 480 500 320 240 0 1e7\n", image), HasSubstr("distortion must be at most 1e6"));
  EXPECT_THAT(refusal_of(lens, "1 1 0 0 0 0 2e9 0 1 a.jpg\n\n"), HasSubstr("its translation must be at most 1e9"));
  EXPECT_THAT(refusal_of(lens, "1 1 1 0 0 0 0 0 1 a.jpg\n"), HasSubstr("images.txt line 1: its rotation"));
  EXPECT_THAT(refusal_of(lens, "1 1 0 0 0 0 0 0 2 a.jpg\n"), HasSubstr("there is no camera 2"));
  EXPECT_THAT(refusal_of(lens, "1 1 0 0 0 0 0 0 1\n"), HasSubstr("has no name"));
  EXPECT_THAT(refusal_of(lens, image + image), HasSubstr("two are called a.jpg"));
}

// Every length at which a file may be cut short, and counts that promise more than there is.
TEST(ColmapModel, RefusesBinaryFilesThatEndEarly) {
  const Sweep sweep;
  BinaryModel model = binary(sweep.cameras);
  const std::vector<uint8_t> cameras = model.cameras.bytes, images = model.images.bytes;
  for (size_t length = 0; length < images.size(); ++length)
    EXPECT_THROW(parse_colmap_binary(cameras, std::span(images).first(length)), std::runtime_error) << length;
  for (size_t length = 0; length < cameras.size(); ++length)
    EXPECT_THROW(parse_colmap_binary(std::span(cameras).first(length), images), std::runtime_error) << length;
  model.images.bytes[7] = 0x10;
  EXPECT_THROW(parse_colmap_binary(cameras, model.images.bytes), std::runtime_error);
}

TEST(ColmapModel, IsAFolderAndBinaryBeforeText) {
  const Sweep sweep;
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "colmap_model";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  EXPECT_THROW(read_cameras(folder), std::runtime_error);
  const auto write = [&](const char* name, const auto& content) {
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
  };
  const ColmapText text = colmap_text({std::span(sweep.cameras).first(1), {}, {}, {}});
  write("cameras.txt", text.cameras), write("images.txt", text.images);
  EXPECT_EQ(read_cameras(folder).size(), 1U);
  const BinaryModel model = binary(sweep.cameras);
  write("cameras.bin", model.cameras.bytes), write("images.bin", model.images.bytes);
  EXPECT_EQ(read_cameras(folder).size(), 2U);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace ldp
