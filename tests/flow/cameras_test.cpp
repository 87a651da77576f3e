// Cameras given to `ldp` that cannot be meant: axes of another program, no lens, another sweep, all at one place;
// and those of photos that a program trimmed.

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/files.h"
#include "core/captures/transforms.h"
#include "sim/scene/picture.h"
#include "sim/scene/scenes.h"
#include "sim/scene/sweep_path.h"
#include "tests/flow/flow.h"

namespace ldp {
namespace {

class GivenCameras : public Flow {
 protected:
  // The true cameras of a small capture, after `change` was done to every frame.
  template <class Change>
  std::vector<std::string> build_with(const Change& change) const {
    const std::string from = capture();
    auto json = nlohmann::json::parse(text_of(from + "/transforms.json"));
    for (auto& frame : json["frames"]) change(json, frame);
    std::ofstream(path("cameras.json")) << json;
    return {"build", from, "-o", path("a.ldp"), "--cameras", path("cameras.json"), "--layers", "1"};
  }
};

TEST_F(GivenCameras, AxesOfOpenCvAreRefusedByThatName) {
  std::vector<std::string> words = build_with([](auto&, auto& frame) {
    for (auto& row : frame["transform_matrix"])
      for (const size_t column : {1U, 2U}) row[column] = -row[column].template get<double>();
  });
  expect_refusal(words, 2, "seem to be OpenCV's or COLMAP's (y down, z forward)");
  words[0] = "poses", words.resize(words.size() - 2), words[3] = path("poses.json");
  expect_refusal(words, 2, "seem to be OpenCV's or COLMAP's (y down, z forward)");
}

TEST_F(GivenCameras, ALensThatIsNoneIsRefusedByItsCamera) {
  expect_refusal(build_with([](auto& json, auto& frame) { json["k1"] = frame["k1"] = 50; }), 2,
                 "cameras.json: frame 000.png: its lens bends the picture beyond measure");
}

TEST_F(GivenCameras, CamerasAtOnePlaceMakeOneFarLayerAndThoseThatPhotosContradictAreDoubted) {
  const Outcome built = ldp(build_with([](auto& json, auto& frame) {
    for (const size_t row : {0U, 1U, 2U})
      frame["transform_matrix"][row][3] = json["frames"][0]["transform_matrix"][row][3];
  }));
  EXPECT_EQ(built.status, 0);
  EXPECT_THAT(built.err, HasSubstr("no parallax was found: one far layer\n"));
  EXPECT_THAT(built.err, HasSubstr("of what photos have in common agrees with the cameras given"));
}

TEST_F(GivenCameras, PhotosOnTheirSideAreToldOfAndTurned) {
  const std::string from = capture(), side = path("side"), cameras = from + "/transforms.json";
  fs::create_directory(side);
  constexpr int kTurnedBack = 8;  // by 270 degrees clockwise
  for (const auto& photo : fs::directory_iterator(from + "/frames"))
    write_file(fs::path(side) / photo.path().filename(), encode_png(upright(read_image(photo.path()), kTurnedBack)));
  const std::string told = "the sweep goes up or down in the photos";
  const Outcome lying = ldp({"poses", side});
  EXPECT_THAT(lying.err, HasSubstr("ldp poses: " + told));
  const Outcome turned = ldp({"poses", side, "--turn", "90", "--cameras", cameras});
  EXPECT_EQ(turned.status, 0);
  const std::string all = std::to_string(std::distance(fs::directory_iterator(side), {}));
  EXPECT_THAT(turned.out, HasSubstr("\n" + all + " of " + all + " photos, "));
  EXPECT_EQ(turned.err, "");
  EXPECT_THAT(ldp({"poses", side, "--turn", "270", "--cameras", cameras}).err,
              HasSubstr("agrees with the cameras given"));
  const Outcome built =
      ldp({"build", side, "-o", path("a.ldp"), "--layers", "1", "--labels", "4", "--iterations", "1"});
  EXPECT_THAT(built.err, HasSubstr("ldp build: " + told));
}

TEST_F(GivenCameras, TheFieldOfViewThatACaptureTellsIsOfPhotosAsTheyAreStored) {
  const std::string from = capture(), notes = from + "/capture.json", report = path("report.json");
  std::ofstream(notes) << R"({"fov_degrees": 200})";
  expect_refusal({"poses", from}, 2, "capture.json: fov_degrees is 200, expected 5 to 150");
  std::ofstream(notes) << R"({"fov_degrees": 40})";
  const auto fov_degrees = [&](const std::string& turn) {
    ldp({"build", from, "-o", path("a.ldp"), "--layers", "1", "--labels", "2", "--turn", turn, "--report", report});
    const auto json = nlohmann::json::parse(text_of(report));
    return json["options"]["fov_degrees"].get<double>();
  };
  const auto json = nlohmann::json::parse(text_of(from + "/transforms.json"));
  const double shape = json["h"].get<double>() / json["w"].get<double>();
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_NEAR(fov_degrees("180"), 40, 1e-9);
  EXPECT_NEAR(fov_degrees("90"), 2 * std::atan(std::tan(20 * kDegree) * shape) / kDegree, 1e-9);
}

TEST_F(GivenCameras, TrueCamerasAreNotSpokenOf) {
  const Outcome built = ldp(build_with([](auto&, auto&) {}));
  EXPECT_EQ(built.status, 0);
  EXPECT_EQ(built.err, "");
}

TEST_F(GivenCameras, AlongALineAreJudgedAsSuch) {
  SweepPath path_of_hand;
  path_of_hand.frames = 6, path_of_hand.width = 160, path_of_hand.height = 120;
  std::vector<Camera> cameras = sweep_cameras(path_of_hand);
  const Scene scene(make_scene("room", 1));
  fs::create_directory(path("line"));
  for (size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].pose = cameras[0].pose;
    cameras[i].pose.centre += 0.1 * static_cast<double>(i) * cameras[0].pose.world_from_camera.col(0);
    write_file(path("line/" + cameras[i].name), encode_png(take_picture(scene, cameras[i], {}, Job{}).colour));
  }
  std::ofstream(path("line.json")) << transforms_json(cameras);
  const Outcome built = ldp({"build", path("line"), "-o", path("a.ldp"), "--cameras", path("line.json"), "--layers",
                             "1", "--report", path("report.json")});
  EXPECT_EQ(built.status, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("the camera moved along a line instead of around"));
  EXPECT_THAT(built.out, testing::Not(HasSubstr("where the camera was is doubtful")));
  EXPECT_EQ(nlohmann::json::parse(text_of(path("report.json")))["poses"]["motion"], "straight");
}

// Cameras go out as a COLMAP model and come in again.
TEST_F(GivenCameras, AreTakenFromTheFolderOfAColmapModel) {
  const std::string from = capture();
  const Outcome written = ldp({"poses", from, "--cameras", from + "/transforms.json", "--colmap", path("sparse")});
  ASSERT_EQ(written.status, 0) << written.err;
  EXPECT_THAT(written.out, testing::EndsWith(path("sparse") + ": cameras and points for COLMAP\n"));
  const Outcome again = ldp({"poses", from, "--cameras", path("sparse"), "-o", path("again.json")});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, testing::EndsWith(path("again.json") + ": the cameras\n"));
  const auto truth = nlohmann::json::parse(text_of(from + "/transforms.json"));
  const auto found = nlohmann::json::parse(text_of(path("again.json")));
  ASSERT_EQ(found["frames"].size(), truth["frames"].size());
  for (size_t i = 0; i < truth["frames"].size(); ++i)
    for (size_t k = 0; k < 16; ++k)
      EXPECT_NEAR(found["frames"][i]["transform_matrix"][k / 4][k % 4].get<double>(),
                  truth["frames"][i]["transform_matrix"][k / 4][k % 4].get<double>(), 1e-9);
  expect_refusal({"build", from, "-o", path("a.ldp"), "--cameras", from}, 2, "holds no COLMAP model");
}

class TrimmedPhotos : public Flow {
 protected:
  static void trim(const std::string& file, int left, int top, int right, int bottom) {
    const RgbImage whole = read_image(file);
    RgbImage cut(whole.width - left - right, whole.height - top - bottom);
    for (int y = 0; y < cut.height; ++y) std::copy_n(whole.row(top + y) + left, cut.width, cut.row(y));
    write_file(file, encode_png(cut));
  }
};

// The camera looks through the middle of each photo as it is stored.
TEST_F(TrimmedPhotos, HaveCamerasOfTheirOwnSizes) {
  const std::string from = path("room");
  ASSERT_EQ(ldp({"scene", "room", "-o", from, "--size", "480x360", "--frames", "5", "--arc", "40"}).status, 0);
  trim(from + "/frames/003.png", 1, 1, 1, 1);
  const Outcome outcome = ldp({"poses", from, "-o", path("poses.json"), "--colmap", path("model")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(text_of(path("poses.json")));
  const auto of = [](const nlohmann::json& frame) {
    return std::array<double, 4>{frame["w"], frame["h"], frame["cx"], frame["cy"]};
  };
  ASSERT_EQ(json["frames"].size(), 5U);
  EXPECT_EQ(of(json["frames"][0]), (std::array<double, 4>{480, 360, 240, 180}));
  EXPECT_EQ(of(json["frames"][3]), (std::array<double, 4>{478, 358, 239, 179}));
  const Outcome built = ldp({"build", from, "-o", path("a.ldp"), "--cameras", path("poses.json"), "--effort", "fast"});
  EXPECT_EQ(built.status, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("5 of 5 photos"));
}

// While they are taken nobody knows what all have: one that differs is left out, and the others are not lost.
TEST_F(TrimmedPhotos, AreLeftOutWhileTheSweepIsFollowed) {
  const std::string from = capture();
  trim(from + "/frames/007.png", 1, 0, 0, 1);
  const Outcome built = Running({"build", from, "-o", path("a.ldp"), "--layers", "1", "--follow"}, room_,
                                fed_by("for i in 0 1 2 3 4 5 6; do echo 00$i.png; done; sleep 0.2; echo end"))
                            .wait();
  EXPECT_EQ(built.status, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("7 of 8 photos"));
}

}  // namespace
}  // namespace ldp
