#include "core/captures/transforms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>

#include "core/base/markup_text.h"
#include "core/captures/json_text.h"

namespace ldp {
namespace {

using ::testing::HasSubstr;

std::vector<Camera> some_cameras() {
  std::vector<Camera> cameras(3);
  for (int i = 0; i < 3; ++i) {
    Camera& camera = cameras[static_cast<size_t>(i)];
    camera.name = "frame_00" + std::to_string(i) + ".jpg";
    camera.intrinsics = {800, 600, 721.5, 722.25, 401.125, 299, -0.1, 0.01, 1e-4, -2e-4};
    const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 1, -0.2).normalized();
    camera.pose.world_from_camera = Eigen::AngleAxisd(0.4 + i, axis).toRotationMatrix();
    camera.pose.centre = {0.1 * i, 1.0 / 3, -2};
  }
  return cameras;
}

void expect_same(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].intrinsics.fy, b[i].intrinsics.fy);
    EXPECT_EQ(a[i].intrinsics.k2, b[i].intrinsics.k2);
    EXPECT_LT((a[i].pose.world_from_camera - b[i].pose.world_from_camera).norm(), 1e-14);
    EXPECT_EQ(a[i].pose.centre, b[i].pose.centre);
  }
}

std::string refusal(const std::string& json) {
  try {
    parse_transforms(json, "t.json");
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "accepted";
}

std::string with(const std::string& shared, const std::string& frame) {
  return "{" + shared + R"("frames":[{"file_path":"images/a.png",)" + frame + "}]}";
}

const std::string kLens = R"("fl_x":500,"w":640,"h":480,)";
const std::string kIdentity = R"("transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";

TEST(Transforms, ReadingGivesBackWhatWasWritten) {
  std::vector<Camera> cameras = some_cameras();
  expect_same(parse_transforms(transforms_json(cameras), "t"), cameras);
  EXPECT_EQ(transforms_json(parse_transforms(transforms_json(cameras), "t")), transforms_json(cameras));
  cameras[1].intrinsics.fy = 700;
  expect_same(parse_transforms(transforms_json(cameras), "t"), cameras);
}

TEST(Transforms, TheIdentityLooksAlongMinusZWithYUp) {
  const Camera camera = parse_transforms(with(kLens, kIdentity), "t").at(0);
  EXPECT_EQ(camera.name, "a.png");
  EXPECT_EQ(camera.pose.world_from_camera.col(2), Eigen::Vector3d(0, 0, -1)) << "forward";
  EXPECT_EQ(camera.pose.world_from_camera.col(1), Eigen::Vector3d(0, -1, 0)) << "down";
}

TEST(Transforms, WhatIsMissingTakesItsDefault) {
  const Camera camera =
      parse_transforms(with(R"("camera_angle_x":1.5707963267948966,"w":640,"h":480,)", kIdentity), "t").at(0);
  EXPECT_NEAR(camera.intrinsics.fx, 320, 1e-9);
  EXPECT_EQ(camera.intrinsics.fy, camera.intrinsics.fx);
  EXPECT_EQ(camera.intrinsics.cx, 320);
  EXPECT_EQ(camera.intrinsics.cy, 240);
  EXPECT_EQ(camera.intrinsics.k1, 0);
}

TEST(Transforms, AFramesOwnFieldsComeFirst) {
  const Camera camera = parse_transforms(with(kLens, R"("fl_x":123,"h":481,)" + kIdentity), "t").at(0);
  EXPECT_EQ(camera.intrinsics.fx, 123);
  EXPECT_EQ(camera.intrinsics.width, 640);
  EXPECT_EQ(camera.intrinsics.height, 481);
}

TEST(Transforms, RoundedRotationsAreMadeExact) {
  const std::string rounded = R"("transform_matrix":[[0.9848,0,0.1736,1],[0,1,0,2],[-0.1736,0,0.9848,3],[0,0,0,1]])";
  const Eigen::Matrix3d r = parse_transforms(with(kLens, rounded), "t").at(0).pose.world_from_camera;
  EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

TEST(Transforms, EveryRefusalNamesFileFrameAndField) {
  EXPECT_THAT(refusal("{"), HasSubstr("t.json: not valid JSON"));
  EXPECT_THAT(refusal("{\"frames\":\n[3,\n"), HasSubstr("not valid JSON in line 3: was it cut short"));
  EXPECT_THAT(refusal("{\"frames\":[1e999]}"), HasSubstr("t.json: not valid JSON: a number in it is too large"));
  for (const std::string word : {"NaN", "nan", "Infinity", "inf"})
    for (const std::string sign : {"", "-"})
      EXPECT_THAT(refusal("{\"frames\":\n[" + sign + word + "]}"),
                  HasSubstr("t.json: " + word + " in line 2: give finite numbers only"));
  EXPECT_THAT(refusal("{\"frames\":\n[nano]}"), HasSubstr("not valid JSON in line 2: was it cut short"));
  for (const std::string end : {"inf", "/nan", " NaN", "Infinity\n"})
    EXPECT_THAT(refusal("{\"frames\":[{\"file_path\":\"" + end),
                HasSubstr("not valid JSON in line 1: was it cut short"));
  EXPECT_THAT(refusal("[]"), HasSubstr("t.json: no list \"frames\""));
  EXPECT_THAT(refusal(R"({"frames":[3]})"), HasSubstr("t.json: frame 0: is not an object"));
  EXPECT_THAT(refusal(R"({"frames":[{}]})"), HasSubstr("t.json: frame 0: file_path is missing"));
  EXPECT_THAT(refusal(with("", kIdentity)), HasSubstr("t.json: frame 0 (a.png): w is missing"));
  EXPECT_THAT(refusal(with(R"("w":640,"h":480,)", kIdentity)), HasSubstr("fl_x is missing"));
  EXPECT_THAT(refusal(with(R"("w":640.5,"h":480,)", kIdentity)), HasSubstr("w must be a whole number of pixels"));
  EXPECT_THAT(refusal(with(kLens + R"("k3":0.1,)", kIdentity)), HasSubstr("k3 is not supported"));
  EXPECT_THAT(refusal(with(kLens + R"("camera_model":"OPENCV_FISHEYE",)", kIdentity)), HasSubstr("OPENCV_FISHEYE"));
  EXPECT_THAT(refusal(with(kLens, R"("x":1)")), HasSubstr("transform_matrix is missing"));
  EXPECT_THAT(refusal(with(kLens, R"("transform_matrix":[[1,0,0],[0,1,0],[0,0,1]])")),
              HasSubstr("4 numbers in each row"));
  EXPECT_THAT(refusal(with(kLens, R"("transform_matrix":[[2,0,0,0],[0,1,0,0],[0,0,1,0]])")),
              HasSubstr("not a rotation"));
  EXPECT_THAT(refusal(with(kLens, R"("transform_matrix":[[-1,0,0,0],[0,1,0,0],[0,0,1,0]])")),
              HasSubstr("not a rotation"));
  EXPECT_THAT(refusal(R"({"fl_x":5,"w":6,"h":4,"frames":[{"file_path":"x/a",)" + kIdentity +
                      R"(},{"file_path":"y/a",)" + kIdentity + "}]}"),
              HasSubstr("a second frame named a"));
}

TEST(Transforms, WhatNoCameraCanBeIsRefused) {
  const auto matrix = [](const std::string& x, const std::string& last) {
    return "\"transform_matrix\":[[1,0,0," + x + "],[0,1,0,0],[0,0,1,0],[" + last + "]]";
  };
  EXPECT_EQ(refusal(with(kLens, matrix("1e9", "0,0,0,1.0000001"))), "accepted");
  EXPECT_THAT(refusal(with(kLens, matrix("-1e30", "0,0,0,1"))), HasSubstr("farther away than 1e9"));
  for (const std::string last : {"1,2,3,0", "0,0,0,2", "0,0,1e-3,1"})
    EXPECT_THAT(refusal(with(kLens, matrix("0", last))), HasSubstr("must end with the row 0 0 0 1"));
  for (const std::string field : {"fl_x", "fl_y", "cx", "cy"})
    for (const std::string length : {"1e30", "2621441"})
      EXPECT_THAT(refusal(with(kLens, "\"" + field + "\":" + length + "," + kIdentity)),
                  HasSubstr("fl_x, fl_y, cx and cy must be at most 4096 times w or h"));
  EXPECT_EQ(refusal(with(kLens, "\"fl_x\":2621440," + kIdentity)), "accepted") << "4096 times 640";
  for (const std::string field : {"k1", "k2", "p1", "p2"})
    EXPECT_THAT(refusal(with(kLens, "\"" + field + "\":-1e30," + kIdentity)), HasSubstr("at most 1e6"));
  for (const std::string path : {"..", "a/..", "a/."})
    EXPECT_THAT(refusal(R"({"frames":[{"file_path":")" + path + "\"}]}"), HasSubstr("file_path names no file"));
  EXPECT_THAT(refusal(R"({"frames":[{"file_path":"a\u0000.png"}]})"), HasSubstr("file_path holds a NUL"));
}

TEST(Transforms, APhotoFindsItsCameraWithOrWithoutExtension) {
  const std::vector<Camera> cameras = some_cameras();
  EXPECT_EQ(find_camera(cameras, "frame_001.jpg"), &cameras[1]);
  EXPECT_EQ(find_camera(cameras, "frame_002.png"), &cameras[2]);
  EXPECT_EQ(find_camera(cameras, "frame_003.jpg"), nullptr);
}

TEST(Transforms, APhotoWhoseNameIsNoUtf8FindsItsCamera) {
  std::vector<Camera> cameras = some_cameras();
  cameras[1].name = "caf\xe9_001.jpg", cameras[2].name = "caf\xc3\xa9_002.jpg";
  const std::vector<Camera> read = parse_transforms(transforms_json(cameras), "t.json");
  EXPECT_EQ(read[1].name, "caf\uFFFD_001.jpg");
  EXPECT_EQ(read[2].name, cameras[2].name);
  for (const std::string ending : {".jpg", ".png"})
    EXPECT_EQ(find_camera(read, "caf\xe9_001" + ending), &read[1]) << ending;
  EXPECT_EQ(find_camera(cameras, "caf\xe9_001.jpg"), &cameras[1]) << "of a program that writes names as they are";
}

TEST(Utf8, KeepsWhatIsUtf8AndReplacesTheRest) {
  const std::string sound = "a\xc3\xa9\xe2\x82\xac\xed\x9f\xbf\xf0\x9f\x93\xb7\xf4\x8f\xbf\xbf";
  EXPECT_EQ(utf8(sound), sound);
  EXPECT_EQ(utf8("caf\xe9"), "caf\uFFFD") << "Latin-1";
  EXPECT_EQ(utf8("\xe2\x82|"), "\uFFFD|") << "cut off";
  EXPECT_EQ(utf8("\xc0\xaf"), "\uFFFD\uFFFD") << "a longer form";
  EXPECT_EQ(utf8("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "half of a pair";
}

TEST(Utf8, ReplacesAsJsonTextDoes) {
  const std::string bytes = "a\x7f\x80\x90\xa0\xbf\xc1\xc2\xe0\xe1\xed\xef\xf0\xf1\xf4\xf5\xff";
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    for (size_t length = random() % 7; text.size() < length;) text += bytes[random() % bytes.size()];
    const std::string told = nlohmann::json::parse(json_text(nlohmann::json(text)));
    EXPECT_EQ(utf8(text), told) << testing::PrintToString(text);
  }
}

TEST(Transforms, TheGardensCamerasLieOnItsArc) {
  const std::filesystem::path file = std::filesystem::path(LDP_SHARED_DATA) / "scenes/garden/transforms.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const std::vector<Camera> cameras = read_transforms(file);
  EXPECT_EQ(cameras.size(), 20u);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) {
    EXPECT_NEAR(camera.pose.world_from_camera.determinant(), 1, 1e-9);
    middle += (camera.pose.centre - 0.7 * camera.pose.world_from_camera.col(2)) / 20;
  }
  for (const Camera& camera : cameras) EXPECT_NEAR((camera.pose.centre - middle).norm(), 0.7, 0.1);
}

}  // namespace
}  // namespace ldp
