#include "core/poses/poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/scene/crowd.h"
#include "sim/scene/picture.h"
#include "sim/scene/scenes.h"
#include "sim/scene/sweep_path.h"
#include "sim/scene_capture.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

using testing::HasSubstr;

class Photos : public FrameSource {
 public:
  explicit Photos(std::vector<RgbImage> images) : images_(std::move(images)) {}
  int size() const override { return static_cast<int>(images_.size()); }
  std::string name(int i) const override { return std::to_string(1000 + i) + ".png"; }
  RgbImage load(int i) const override { return images_[static_cast<size_t>(i)]; }
  std::optional<double> focal_hint(int) const override { return std::nullopt; }

 private:
  std::vector<RgbImage> images_;
};

Photos photos_of(const Scene& scene, const std::vector<Camera>& cameras) {
  std::vector<RgbImage> images;
  for (const Camera& camera : cameras) images.push_back(take_picture(scene, camera, PictureOptions{}, Job{}).colour);
  return Photos(std::move(images));
}

struct Rendered {
  std::vector<Camera> cameras;
  std::vector<RgbImage> images;
};

SweepPath short_path(double radius) {
  SweepPath path;
  path.frames = 8;
  path.arc_rad = 70 * kDegree;
  path.radius = radius;
  path.width = 400, path.height = 300;
  path.position_jitter = radius > 0 ? 0.01 : 0;
  return path;
}

const Rendered& rendered(double radius) {
  const auto make = [](double r) {
    const Scene scene(make_scene("courtyard", 1));
    Rendered result{sweep_cameras(short_path(r)), {}};
    for (size_t i = 0; i < result.cameras.size(); ++i) {
      PictureOptions options;
      options.noise = 1;
      options.noise_seed = i;
      result.images.push_back(take_picture(scene, result.cameras[i], options, Job{}).colour);
      result.cameras[i].name = std::to_string(1000 + i) + ".png";
    }
    return result;
  };
  static const Rendered arc = make(0.65), spot = make(0);
  return radius > 0 ? arc : spot;
}

bool same_bytes(const Poses& a, const Poses& b) {
  if (a.cameras.size() != b.cameras.size() || a.points.size() != b.points.size()) return false;
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    if (a.cameras[i].pose.centre != b.cameras[i].pose.centre) return false;
    if (a.cameras[i].pose.world_from_camera != b.cameras[i].pose.world_from_camera) return false;
    if (a.cameras[i].intrinsics.fx != b.cameras[i].intrinsics.fx) return false;
  }
  return true;
}

const Poses& estimated() {
  static const Poses poses = estimate_poses(Photos(rendered(0.65).images), PosesOptions{}, Job{});
  return poses;
}

TEST(EstimatePoses, PosesEveryFrameOfASyntheticSweep) {
  const Poses& poses = estimated();
  ASSERT_EQ(poses.cameras.size(), 8U);
  EXPECT_EQ(poses.report.motion, Motion::arc);
  EXPECT_FALSE(poses.report.closed);
  EXPECT_LT(poses.report.reprojection_px, 1);
  const std::vector<Camera>& truth = rendered(0.65).cameras;
  EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.02);
  for (size_t i = 1; i < 8; ++i) {
    const Eigen::Matrix3d found =
        poses.cameras[i].pose.world_from_camera.transpose() * poses.cameras[0].pose.world_from_camera;
    const Eigen::Matrix3d wanted = truth[i].pose.world_from_camera.transpose() * truth[0].pose.world_from_camera;
    EXPECT_LT(angle_deg(found, wanted), 1);
  }
}

// The widest angle between a step of these cameras and the same one of those.
double worst_step_deg(const std::vector<Camera>& found, const std::vector<Camera>& truth) {
  double worst = 0;
  for (size_t i = 1; i < truth.size(); ++i) {
    const auto step = [i](const std::vector<Camera>& c) {
      return Eigen::Matrix3d(c[i - 1].pose.world_from_camera.transpose() * c[i].pose.world_from_camera);
    };
    worst = std::max(worst, angle_deg(step(found), step(truth)));
  }
  return worst;
}

// Steps that differ by as much as a hand strays from its circle: kept near it, cameras would turn to fit what they see.
TEST(EstimatePoses, AreThoseOfAHandThatStrays) {
  SweepPath path = short_path(0.65);
  path.frames = 16;
  path.arc_rad = 360 * kDegree;
  path.fov_rad = 65 * kDegree;
  path.position_jitter = 0.05;
  path.seed = 1;
  const Scene scene(make_scene("courtyard", 1));
  const std::vector<Camera> truth = sweep_cameras(path);
  const Poses poses = estimate_poses(photos_of(scene, truth), PosesOptions{}, Job{});
  ASSERT_EQ(poses.cameras.size(), truth.size());
  EXPECT_LT(worst_step_deg(poses.cameras, truth), 0.1);
}

struct AmongPeople {
  Poses poses;
  double worst_step_deg;
  bool progress_fell;
};

AmongPeople posed_among_people(const char* scene, const SweepPath& path, uint32_t seed) {
  const std::vector<Camera> cameras = sweep_cameras(path);
  std::vector<RgbImage> images;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const Scene moment(with_crowd(make_scene(scene, seed), path, 0.3, static_cast<int>(i), seed));
    images.push_back(take_picture(moment, cameras[i], PictureOptions{}, Job{}).colour);
  }
  Job job;
  double told = 0;
  bool fell = false;
  job.progress = [&](std::string_view, double fraction) {
    fell = fell || fraction < told;
    told = fraction;
  };
  Poses poses = estimate_poses(Photos(std::move(images)), PosesOptions{}, job);
  const double worst = poses.cameras.size() == cameras.size() ? worst_step_deg(poses.cameras, cameras) : 180;
  return {std::move(poses), worst, fell};
}

TEST(EstimatePoses, AreThoseOfWhatStandsStillWherePeopleWalkBy) {
  SweepPath path = short_path(0.65);
  path.arc_rad = 40 * kDegree;
  for (const char* scene : {"garden", "room"})
    EXPECT_LT(posed_among_people(scene, path, 1).worst_step_deg, 0.05) << scene;
}

// Tracked the longest are people who keep pace with the camera, and by them it only turned on the spot.
TEST(EstimatePoses, BelieveWhatExplainsMorePartsOfThePhotosWherePeopleLeadAstray) {
  SweepPath path = short_path(0.93);
  path.arc_rad = 60 * kDegree;
  path.fov_rad = 73 * kDegree;
  path.seed = 2;
  const AmongPeople found = posed_among_people("terrace", path, 2);
  EXPECT_EQ(found.poses.report.motion, Motion::arc);
  EXPECT_LT(found.worst_step_deg, 0.05);
  EXPECT_FALSE(found.progress_fell);
}

TEST(EstimatePoses, LeavesAStraightLensStraight) {
  EXPECT_EQ(estimated().cameras[0].intrinsics.k1, 0);
  EXPECT_EQ(estimated().cameras[0].intrinsics.k2, 0);
}

TEST(EstimatePoses, WorldIsUprightAndOfArmsLength) {
  double radius = 0;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const Camera& camera : estimated().cameras) {
    up -= camera.pose.world_from_camera.col(1) / 8;
    radius += camera.pose.centre.norm() / 8;
  }
  EXPECT_GT(up.normalized().z(), std::cos(1 * kDegree));
  EXPECT_NEAR(radius, 0.65, 0.15);
}

// Every pixel between the middles of the small one's, as a camera of so many times its pixels sees them.
RgbImage enlarged(const RgbImage& small, int times) {
  RgbImage big(small.width * times, small.height * times);
  for (int y = 0; y < big.height; ++y) {
    for (int x = 0; x < big.width; ++x) {
      const double u = std::clamp((x + 0.5) / times - 0.5, 0.0, small.width - 1.001),
                   v = std::clamp((y + 0.5) / times - 0.5, 0.0, small.height - 1.001);
      const int i = static_cast<int>(u), j = static_cast<int>(v);
      const auto blend = [&](uint8_t Rgb::*channel) {
        const auto at = [&](int p, int q) { return static_cast<double>(small.at(p, q).*channel); };
        const double top = at(i, j) + (u - i) * (at(i + 1, j) - at(i, j));
        const double bottom = at(i, j + 1) + (u - i) * (at(i + 1, j + 1) - at(i, j + 1));
        return static_cast<uint8_t>(std::lround(top + (v - j) * (bottom - top)));
      };
      big.at(x, y) = {blend(&Rgb::r), blend(&Rgb::g), blend(&Rgb::b)};
    }
  }
  return big;
}

TEST(EstimatePoses, OfPhotosShrunkForTheWorkAreInPixelsOfTheWholePhoto) {
  constexpr int kTimes = 3;  // 1200 x 900: more than is worked on
  std::vector<RgbImage> big;
  for (const RgbImage& image : rendered(0.65).images) big.push_back(enlarged(image, kTimes));
  const Poses poses = estimate_poses(Photos(std::move(big)), PosesOptions{}, Job{});
  ASSERT_EQ(poses.cameras.size(), 8U);
  const Intrinsics &k = poses.cameras[0].intrinsics, &small = rendered(0.65).cameras[0].intrinsics;
  EXPECT_EQ(k.width, kTimes * 400);
  EXPECT_EQ(k.height, kTimes * 300);
  EXPECT_EQ(k.cx, kTimes * 200);
  EXPECT_NEAR(k.fx / (kTimes * small.fx), 1, 0.02);
  double squared = 0, count = 0, rightmost = 0;
  for (size_t i = 0; i < poses.points.size(); ++i) {
    for (size_t j = 0; j < poses.sightings[i].size(); ++j) {
      const Pose& pose = poses.cameras[static_cast<size_t>(poses.points[i].cameras[j])].pose;
      const Eigen::Vector3d seen = pose.world_from_camera.transpose() * (poses.points[i].position - pose.centre);
      squared += (project(k, seen) - poses.sightings[i][j]).squaredNorm(), ++count;
      rightmost = std::max(rightmost, poses.sightings[i][j].x());
    }
  }
  EXPECT_LT(std::sqrt(squared / count), kTimes * 0.5);
  EXPECT_GT(rightmost, kTimes * 380);
}

TEST(EstimatePoses, GivesTheSameBytesAtAnyThreadCount) {
  for (const int threads : {1, 2, 4}) {
    Job job;
    job.threads = threads;
    EXPECT_TRUE(same_bytes(estimated(), estimate_poses(Photos(rendered(0.65).images), PosesOptions{}, job))) << threads;
  }
}

class HintedPhotos : public Photos {
 public:
  HintedPhotos(std::vector<RgbImage> images, std::vector<std::optional<double>> hints)
      : Photos(std::move(images)), hints_(std::move(hints)) {}
  std::optional<double> focal_hint(int i) const override { return hints_[static_cast<size_t>(i)]; }

 private:
  std::vector<std::optional<double>> hints_;
};

TEST(EstimatePoses, TakesTheMedianOfWhatThePhotosTellOfTheirLens) {
  const std::vector<RgbImage>& images = rendered(0.65).images;
  const Intrinsics& k = rendered(0.65).cameras[0].intrinsics;
  const double longer_sides = k.fx / k.width, wrong = 0.4 * longer_sides;
  const auto with = [&](const std::vector<std::optional<double>>& hints) {
    return estimate_poses(HintedPhotos(images, hints), PosesOptions{}, Job{});
  };
  const Poses right = with(std::vector<std::optional<double>>(8, longer_sides));
  EXPECT_NEAR(right.cameras[0].intrinsics.fx / k.fx, 1, 0.02);
  EXPECT_FALSE(same_bytes(right, estimated())) << "the hints count";
  const Poses median =
      with({wrong, longer_sides, wrong, longer_sides, std::nullopt, wrong, longer_sides, longer_sides});
  EXPECT_TRUE(same_bytes(right, median));
}

// As an editor's thumbnail among them is, and one of another camera.
TEST(EstimatePoses, PhotosOfAnotherSizeTellNothingOfTheLens) {
  const Intrinsics& k = rendered(0.65).cameras[0].intrinsics;
  std::vector<RgbImage> images = rendered(0.65).images;
  images.insert(images.begin(), RgbImage(2 * k.width, 2 * k.height));
  images.push_back(RgbImage(k.width, k.height / 2));
  std::vector<std::optional<double>> hints(10, k.fx / k.width);
  hints.front() = hints.back() = 0.2;
  for (size_t i = 2; i < 9; ++i) hints[i].reset();  // one alone says it, of three that tell something
  const Poses by_hints = estimate_poses(HintedPhotos(images, hints), PosesOptions{}, Job{});
  ASSERT_EQ(by_hints.cameras.size(), 8U);
  EXPECT_NEAR(by_hints.report.told_focal, 1, 0.02);
  PosesOptions told;
  told.fov_rad = 2 * std::atan(0.5 * k.width / k.fx);
  const Poses by_view = estimate_poses(Photos(images), told, Job{}),
              alone = estimate_poses(Photos(rendered(0.65).images), told, Job{});
  ASSERT_EQ(by_view.cameras.size(), 8U);
  EXPECT_NEAR(by_view.cameras[0].intrinsics.fx / alone.cameras[0].intrinsics.fx, 1, 1e-4);
}

TEST(PoseEstimator, GivesTheSameBytesAsAllFramesAtOnceHoweverTheyArrive) {
  const Photos photos(rendered(0.65).images);
  PoseEstimator by_one{PosesOptions{}}, in_heaps{PosesOptions{}};
  for (int count = 1; count <= photos.size(); ++count) by_one.add_frames(photos, count, Job{});
  EXPECT_TRUE(same_bytes(estimated(), by_one.finish(Job{})));
  Job job;
  job.threads = 3;
  for (const int count : {0, 2, 2, 7}) in_heaps.add_frames(photos, count, job);
  EXPECT_EQ(in_heaps.size(), 7);
  EXPECT_TRUE(same_bytes(estimated(), estimate_poses(photos, std::move(in_heaps), job)));
}

// With so many eighths of its contrast.
RgbImage pale(const RgbImage& image, int eighths) {
  RgbImage result = image;
  for (Rgb& pixel : result.samples) {
    for (uint8_t* channel : {&pixel.r, &pixel.g, &pixel.b})
      *channel = static_cast<uint8_t>(128 + (*channel - 128) * eighths / 8);
  }
  return result;
}

TEST(PoseEstimator, OfManyFramesThoseThatShowWhatOthersShowChangeNothing) {
  std::vector<RgbImage> images;
  for (const RgbImage& image : rendered(0.65).images) {
    for (const int eighths : {5, 6, 7, 8, 7, 6}) images.push_back(pale(image, eighths));
  }
  const Photos photos(images);
  PoseEstimator in_heaps{PosesOptions{}};
  for (const int count : {20, 42}) in_heaps.add_frames(photos, count, Job{});
  const Poses poses = estimate_poses(photos, std::move(in_heaps), Job{});
  EXPECT_TRUE(same_bytes(estimated(), poses));
  for (size_t i = 0; i < images.size(); ++i)
    EXPECT_EQ(poses.report.frames[i].left_out.cause, i % 6 == 3 ? LeftOutCause::none : LeftOutCause::needless) << i;
  EXPECT_THAT(words_of(poses.report.frames[7].left_out), HasSubstr("1009.png"));
}

TEST(PoseEstimator, BeginsAnewWhenItsFramesAreNotTheFirstOfTheSource) {
  class Renamed : public Photos {
   public:
    using Photos::Photos;
    std::string name(int i) const override { return "other_" + Photos::name(i); }
  };
  const std::vector<RgbImage>& images = rendered(0.65).images;
  PoseEstimator others{PosesOptions{}}, too_many{PosesOptions{}};
  others.add_frames(Renamed({images[4], images[1]}), 2, Job{});
  EXPECT_TRUE(same_bytes(estimated(), estimate_poses(Photos(images), std::move(others), Job{})));
  std::vector<RgbImage> more = images;
  more.push_back(images[0]);
  too_many.add_frames(Photos(more), 9, Job{});
  EXPECT_TRUE(same_bytes(estimated(), estimate_poses(Photos(images), std::move(too_many), Job{})));
}

// The photos were cropped after it was written, or enlarged.
TEST(EstimatePoses, TellsOfExifThatSpeaksOfAnotherLens) {
  class WithExif : public Photos {
   public:
    WithExif(const std::vector<RgbImage>& images, double hint) : Photos(images), hint_(hint) {}
    std::optional<double> focal_hint(int /*index*/) const override { return hint_; }

   private:
    double hint_;
  };
  const std::vector<RgbImage>& images = rendered(0.65).images;
  const Intrinsics truth = estimated().cameras[0].intrinsics;
  const auto with = [&](double factor) {
    return estimate_poses(WithExif(images, factor * truth.fx / truth.width), PosesOptions{}, Job{});
  };
  EXPECT_EQ(wrong_lens(with(1.1)), "");
  EXPECT_EQ(wrong_lens(estimated()), "");
  const Poses wrong = with(1.5);
  EXPECT_NEAR(wrong.cameras[0].intrinsics.fx / truth.fx, 1, 0.01);
  EXPECT_THAT(wrong_lens(wrong), HasSubstr("EXIF tells a focal length of 1.5"));
}

// Its pull would bend the weakest joint of a sweep.
TEST(EstimatePoses, TellsOfAFieldOfViewThatIsOfAnotherLens) {
  const Intrinsics truth = estimated().cameras[0].intrinsics;
  const auto with = [&](double factor) {
    PosesOptions told;
    told.fov_rad = 2 * std::atan(0.5 * truth.width / (factor * truth.fx));
    return estimate_poses(Photos(rendered(0.65).images), told, Job{});
  };
  EXPECT_EQ(wrong_lens(with(1.1)), "");
  const Poses wrong = with(1.5);
  EXPECT_NEAR(wrong.cameras[0].intrinsics.fx / truth.fx, 1, 1e-9) << "as if none had been told";
  EXPECT_THAT(wrong_lens(wrong), HasSubstr("degrees, which was taken instead of the one given"));
}

// As where a program made photos smaller and left EXIF as it was. With so long a lens nothing fits at all, or photos
// are lost.
TEST(EstimatePoses, WhatIsToldOfTheLensIsLeftOutWhereNothingOrLittleComesOfIt) {
  for (const char* const scene : {"terrace", "courtyard"}) {
    SweepPath path;
    path.frames = 9, path.width = 320, path.height = 240;
    path.arc_rad = 198 * kDegree, path.fov_rad = 75 * kDegree;
    path.seed = 5;
    const std::vector<Camera> truth = sweep_cameras(path);
    PosesOptions told;
    told.fov_rad = 10 * kDegree;
    const Poses poses = estimate_poses(photos_of(Scene(make_scene(scene, 5)), truth), told, Job{});
    ASSERT_EQ(poses.cameras.size(), truth.size()) << scene;
    EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.01) << scene;
    EXPECT_THAT(wrong_lens(poses), HasSubstr("which was taken instead of the one given")) << scene;
  }
}

RgbImage noise_picture(unsigned seed) {
  std::mt19937 random(seed);
  RgbImage image(320, 240);
  for (Rgb& pixel : image.samples) pixel.r = pixel.g = pixel.b = static_cast<uint8_t>(random());
  return image;
}

// Nothing better is found without; and of photos that do not belong together a few make no sweep.
TEST(EstimatePoses, WhatIsToldOfTheLensStaysWherePhotosAreLostForOtherReasons) {
  SweepPath path;
  path.frames = 6, path.width = 320, path.height = 240;
  path.arc_rad = 132 * kDegree, path.fov_rad = 95 * kDegree, path.k1 = -0.2;
  path.seed = 5;
  const std::vector<Camera> truth = sweep_cameras(path);
  const Photos own = photos_of(Scene(make_scene("courtyard", 5)), truth);
  std::vector<RgbImage> images;
  for (int i = 0; i < own.size(); ++i) images.push_back(own.load(i));
  images.push_back(noise_picture(1));
  PosesOptions told;
  told.fov_rad = path.fov_rad;
  const Poses poses = estimate_poses(Photos(images), told, Job{});
  ASSERT_EQ(poses.cameras.size(), truth.size());
  EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.02);
  EXPECT_EQ(wrong_lens(poses), "");

  path.k1 = 0, path.frames = 9, path.arc_rad = 198 * kDegree, path.fov_rad = 75 * kDegree;
  const Photos others = photos_of(Scene(make_scene("room", 5)), sweep_cameras(path));
  images.clear();
  for (int i = 0; i < 3; ++i) images.push_back(others.load(i));
  for (unsigned seed = 1; seed < 5; ++seed) images.push_back(noise_picture(seed));
  EXPECT_EQ(estimate_poses(Photos(images), PosesOptions{}, Job{}).cameras.size(), 3U);
  told.fov_rad = 10 * kDegree;
  EXPECT_THROW(estimate_poses(Photos(images), told, Job{}), Impossible);
}

TEST(EstimatePoses, RecognisesARotationOnTheSpot) {
  const Poses poses = estimate_poses(Photos(rendered(0).images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.report.motion, Motion::rotation);
  EXPECT_EQ(poses.cameras.size(), 8U);
}

// What a shaking hand moves against near things is no arc: one would be found with another focal length.
TEST(EstimatePoses, RecognisesARotationOfAHandThatShakes) {
  struct Case {
    const char* scene;
    uint32_t seed;
    double jitter;
  };
  for (const Case& c : {Case{"garden", 4, 0.005}, {"room", 2, 0.01}, {"room", 5, 0.01}}) {
    SweepPath path;
    path.frames = 12;
    path.fov_rad = 65 * kDegree;
    path.arc_rad = 140 * kDegree;
    path.radius = 0, path.position_jitter = c.jitter;
    path.width = 256, path.height = 192;
    path.seed = c.seed;
    const Scene scene(make_scene(c.scene, c.seed));
    const std::vector<Camera> truth = sweep_cameras(path);
    const Poses poses = estimate_poses(photos_of(scene, truth), PosesOptions{}, Job{});
    EXPECT_EQ(poses.report.motion, Motion::rotation) << c.scene << c.seed;
    EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.015) << c.scene << c.seed;
  }
}

// A rotation explains a short arc seen through a wide lens to a few pixels, if it may choose how the lens bends, and
// with another focal length: the parallax would be lost, and the panorama flat.
TEST(EstimatePoses, KeepsAShortArcThroughAWideLens) {
  struct Case {
    const char* scene;
    uint32_t seed;
    double radius, fov_deg, k1;
  };
  for (const Case& c : {Case{"room", 2, 0.15, 85, 0}, {"garden", 3, 0.2, 75, -0.12}}) {
    SweepPath path;
    path.frames = 8;
    path.fov_rad = c.fov_deg * kDegree;
    path.arc_rad = 30 * kDegree;
    path.radius = c.radius, path.position_jitter = 0.006;
    path.width = 320, path.height = 240;
    path.k1 = c.k1;
    path.seed = c.seed;
    const Scene scene(make_scene(c.scene, c.seed));
    const std::vector<Camera> truth = sweep_cameras(path);
    const Poses poses = estimate_poses(photos_of(scene, truth), PosesOptions{}, Job{});
    EXPECT_EQ(poses.report.motion, Motion::arc) << c.scene;
    EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.01) << c.scene;
  }
}

// Narrow views, many steps and a lens that bends: a few degrees to the side would pass for a turn in every step, and
// half the focal length with them.
TEST(EstimatePoses, RecognisesARotationAllRoundThroughALensThatBends) {
  const Scene scene(make_scene("courtyard", 1));
  SweepPath path;
  path.frames = 18;
  path.arc_rad = 342 * kDegree;
  path.radius = path.position_jitter = 0;
  path.fov_rad = 36 * kDegree;
  path.width = 300, path.height = 400;
  path.k1 = -0.18;
  const std::vector<Camera> truth = sweep_cameras(path);
  const Poses poses = estimate_poses(photos_of(scene, truth), PosesOptions{}, Job{});
  EXPECT_EQ(poses.report.motion, Motion::rotation);
  EXPECT_EQ(poses.report.doubt, "");
  ASSERT_EQ(poses.cameras.size(), truth.size());
  EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.01);
}

// Another focal length, and steps that turn more or less, stand in for a little bending nearly as well.
TEST(EstimatePoses, FindsALensThatBendsALittle) {
  struct Case {
    const char* scene;
    int frames;
    double arc_deg, radius, fov_deg, k1;
  };
  for (const Case& c : {Case{"terrace", 4, 60, 0.8, 58, 0.04},
                        {"courtyard", 8, 60, 0.8, 58, -0.03},
                        {"garden", 9, 90, 0.25, 45, 0.02}}) {
    SweepPath path;
    path.frames = c.frames;
    path.arc_rad = c.arc_deg * kDegree;
    path.radius = c.radius;
    path.fov_rad = c.fov_deg * kDegree;
    path.width = 320, path.height = 240;
    path.k1 = c.k1;
    const Scene scene(make_scene(c.scene, 1));
    const std::vector<Camera> truth = sweep_cameras(path);
    const Poses poses = estimate_poses(photos_of(scene, truth), PosesOptions{}, Job{});
    ASSERT_EQ(poses.cameras.size(), truth.size()) << c.scene;
    EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.01) << c.scene;
    EXPECT_NEAR(poses.cameras[0].intrinsics.k1, c.k1, 0.01) << c.scene;
  }
}

// A wide lens that bends strongly looks like a narrow one that does not, of a sweep that turned less: also where a lens
// was told that is too far off to be kept, which is told then.
TEST(EstimatePoses, FindsAWideLensThatBendsStrongly) {
  SweepPath path;
  path.frames = 14;
  path.arc_rad = 120 * kDegree;
  path.radius = 0.6, path.position_jitter = 0.008;
  path.fov_rad = 95 * kDegree;
  path.width = 320, path.height = 240;
  path.k1 = -0.25;
  path.seed = 1;
  const Scene scene(make_scene("room", 1));
  const std::vector<Camera> truth = sweep_cameras(path);
  const Photos photos = photos_of(scene, truth);
  for (const std::optional<double>& told_rad : {std::optional<double>(), std::optional(109 * kDegree)}) {
    PosesOptions options;
    options.fov_rad = told_rad;
    const Poses poses = estimate_poses(photos, options, Job{});
    EXPECT_EQ(poses.report.motion, Motion::arc);
    ASSERT_EQ(poses.cameras.size(), truth.size());
    EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.02) << told_rad.has_value();
    EXPECT_NEAR(poses.cameras[0].intrinsics.k1, path.k1, 0.02) << told_rad.has_value();
    EXPECT_EQ(poses.report.told_focal < 0.85, told_rad.has_value()) << "as is told";
  }
}

// The wide lens that is tried in case is a guess. As evidence it would shorten the focal length here, and bend the
// lens.
TEST(EstimatePoses, AGuessOfAWideLensIsNoEvidence) {
  SceneCaptureOptions options;
  options.scene = "garden";
  options.seed = options.path.seed = 1006;
  options.path.frames = 16;
  options.path.radius = 0.8;
  options.path.fov_rad = 35 * kDegree;
  options.path.position_jitter = 0.03, options.path.angle_jitter_rad = 1.2 * kDegree;
  options.path.width = 320, options.path.height = 240;
  options.noise = 1;
  const SceneSweep sweep(options);
  std::vector<RgbImage> images;
  for (int i = 0; i < options.path.frames; ++i) images.push_back(sweep.take(i, Job{}).colour);
  const Poses poses = estimate_poses(Photos(std::move(images)), PosesOptions{}, Job{});
  EXPECT_NEAR(poses.cameras[0].intrinsics.fx / sweep.cameras()[0].intrinsics.fx, 1, 0.01);
}

TEST(EstimatePoses, DropsAPhotoOfNothingAndNamesIt) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images[3] = RgbImage(400, 300, Rgb{90, 90, 90});
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.cameras.size(), 7U);
  EXPECT_FALSE(poses.report.frames[3].posed);
  EXPECT_THAT(words_of(poses.report.frames[3].left_out), HasSubstr("no texture"));
}

TEST(EstimatePoses, BearsAPhotoOfNothingInTheMiddle) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images[images.size() / 2] = RgbImage(400, 300, Rgb{90, 90, 90});
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.cameras.size(), images.size() - 1);
  EXPECT_EQ(poses.report.motion, Motion::arc);
}

TEST(EstimatePoses, DropsAPhotoOfAnotherSizeAndSaysSo) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images[7] = RgbImage(300, 400, Rgb{});
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.cameras.size(), 7U);
  EXPECT_EQ(poses.report.frames[7].left_out.cause, LeftOutCause::other_size);
}

TEST(EstimatePoses, DropsAPhotoThatRepeatsTheOneBefore) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images.insert(images.begin() + 4, 2, images[3]);
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_THAT(words_of(poses.report.frames[4].left_out), HasSubstr("the same picture as 1003.png"));
  EXPECT_THAT(words_of(poses.report.frames[5].left_out), HasSubstr("the same picture as 1004.png"));
  ASSERT_EQ(poses.cameras.size(), 8U);
  for (size_t i = 0; i < 8; ++i)
    EXPECT_LT((poses.cameras[i].pose.centre - estimated().cameras[i].pose.centre).norm(), 0.01) << i;
}

TEST(EstimatePoses, SaysWhyItIsImpossible) {
  const std::vector<RgbImage> two(rendered(0.65).images.begin(), rendered(0.65).images.begin() + 2);
  const auto words = [](const std::vector<RgbImage>& images) {
    try {
      estimate_poses(Photos(images), PosesOptions{}, Job{});
    } catch (const Impossible& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(words(two), HasSubstr("at least 3 photos"));
  const std::string blank = words(std::vector<RgbImage>(4, RgbImage(200, 150, Rgb{50, 60, 70})));
  EXPECT_THAT(blank, HasSubstr("only 1 of 4 photos connect with each other"));
  EXPECT_THAT(blank, HasSubstr("most show next to no texture"));
  EXPECT_THAT(words(std::vector<RgbImage>(4, two[0])),
              HasSubstr("none the same as the one before; 1001.png: it is the same picture as 1000.png"));
  std::mt19937 random(3);
  std::vector<RgbImage> noise(4, RgbImage(200, 150));
  for (RgbImage& image : noise) {
    for (Rgb& pixel : image.samples) pixel.r = pixel.g = pixel.b = static_cast<uint8_t>(random());
  }
  std::vector<RgbImage> repeated = noise;
  repeated.insert(repeated.begin() + 2, noise[1]);
  EXPECT_THAT(words(repeated), HasSubstr("of 5 photos connect with each other"));
  EXPECT_THAT(words(repeated), HasSubstr("; left out was 1002.png: it is the same picture as 1001.png"));
  EXPECT_THAT(words(noise), HasSubstr("sharp and free of noise"));
}

TEST(EstimatePoses, StopsWhenAsked) {
  std::stop_source stop;
  Job job;
  job.stop = stop.get_token();
  stop.request_stop();
  EXPECT_THROW(estimate_poses(Photos(rendered(0.65).images), PosesOptions{}, job), Cancelled);
}

TEST(Triangulate, FindsPointsAndLeavesGivenCamerasAlone) {
  const Rendered& r = rendered(0.65);
  const Poses poses = triangulate(Photos(r.images), r.cameras, PosesOptions{}, Job{});
  ASSERT_EQ(poses.cameras.size(), 8U);
  EXPECT_GT(poses.points.size(), 100U);
  EXPECT_LT(poses.report.reprojection_px, 0.7);
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(poses.cameras[i].pose.centre, r.cameras[i].pose.centre);
}

TEST(Triangulate, NamesFramesWithoutACamera) {
  const Rendered& r = rendered(0.65);
  const std::vector<Camera> some(r.cameras.begin(), r.cameras.begin() + 5);
  const Poses poses = triangulate(Photos(r.images), some, PosesOptions{}, Job{});
  EXPECT_FALSE(poses.report.frames[6].posed);
  EXPECT_THAT(words_of(poses.report.frames[6].left_out), HasSubstr("no camera"));
  EXPECT_THROW(triangulate(Photos(r.images), {some[0], some[1]}, PosesOptions{}, Job{}), Impossible);
}

}  // namespace
}  // namespace ldp::sfm
