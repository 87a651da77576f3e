#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/base/files.h"
#include "core/captures/folder_frames.h"
#include "core/photos/images.h"
#include "core/photos/resize.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class FolderFramesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("frames_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void photo(const std::string& name, int width = 40, int height = 30, uint8_t grey = 90) const {
    const RgbImage image(width, height, {grey, grey, grey});
    write_file(folder_ / name, name.ends_with("png") ? encode_png(image) : encode_jpeg(image, 90));
  }
  void text(const std::string& name, const std::string& content) const { write_file(folder_ / name, content); }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    const FolderFrames frames(folder_);
    for (int i = 0; i < frames.size(); ++i) all.push_back(frames.name(i));
    return all;
  }
  std::string refusal() const {
    try {
      FolderFrames frames(folder_);
      for (int i = 0; i < frames.size(); ++i) frames.load(i);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(FolderFramesTest, TakesPhotosOfAnyCaseInNameOrderWithNumbersByValue) {
  for (const char* name : {"IMG_10.JPG", "IMG_9.jpeg", "IMG_011.png", ".IMG_1.jpg"}) photo(name);
  text("notes.txt", "not a photo");
  EXPECT_THAT(names(), ElementsAre("IMG_9.jpeg", "IMG_10.JPG", "IMG_011.png"));
}

TEST_F(FolderFramesTest, FallsBackToTheSubfolderFrames) {
  fs::create_directory(folder_ / "frames");
  photo("frames/b.png");
  photo("frames/a.png");
  EXPECT_THAT(names(), ElementsAre("a.png", "b.png"));
}

TEST_F(FolderFramesTest, SaysThatAFolderIsEmpty) { EXPECT_THAT(refusal(), HasSubstr("no .jpg or .png photos")); }

TEST_F(FolderFramesTest, SaysInWhichFoldersOfItPhotosAre) {
  for (const char* const name : {"rgb_10", "rgb_9", ".hidden", "masks"}) fs::create_directory(folder_ / name);
  for (const char* const name : {"rgb_10/a.jpg", ".hidden/a.jpg"}) photo(name);
  text("masks/notes.txt", "");
  fs::create_symlink("loop", folder_ / "loop");
  EXPECT_THAT(refusal(), HasSubstr("no .jpg or .png photos in it but in its folder rgb_10: give that"));
  photo("rgb_9/a.jpg");
  const std::string told = "but in its folders rgb_9 and rgb_10: give the one with the sweep's photos";
  EXPECT_THAT(refusal(), HasSubstr(told));
  fs::create_directory(folder_ / "frames");
  EXPECT_THAT(refusal(), HasSubstr(told));
}

TEST_F(FolderFramesTest, SaysThatAFolderIsMissing) {
  fs::remove_all(folder_);
  EXPECT_THAT(refusal(), HasSubstr("there is no such folder"));
}

TEST_F(FolderFramesTest, NamesBothPhotosWhenSizesAreMixed) {
  photo("a.jpg");
  photo("b.jpg", 41, 30);
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("a.jpg is 40x30"), HasSubstr("b.jpg 41x30")));
}

TEST_F(FolderFramesTest, TakesAFewPhotosOfOtherSizesAsTheyAre) {
  for (const char* const name : {"a.jpg", "b.jpg", "d.jpg"}) photo(name);
  photo("c.jpg", 30, 40);
  const FolderFrames frames(folder_);
  EXPECT_EQ(frames.stored_size(), (ImageSize{40, 30}));
  EXPECT_EQ(frames.load(1).width, 40);
  EXPECT_EQ(frames.load(2).width, 30);
  Camera camera;
  camera.intrinsics = {40, 30, 30, 30, 20, 15};
  std::vector<Camera> cameras(4, camera);
  for (size_t i = 0; i < 4; ++i) cameras[i].name = frames.name(static_cast<int>(i));
  std::vector<std::string> fitted;
  for (const Camera& of : frames.fit(cameras)) fitted.push_back(of.name);
  EXPECT_THAT(fitted, ElementsAre("a.jpg", "b.jpg", "d.jpg"));
  photo("e.jpg", 30, 40);
  photo("f.jpg", 30, 40);
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("a.jpg is 40x30"), HasSubstr("c.jpg 30x40")));
}

// As programs leave them that turn photos or take the lens's bending out: each is trimmed a little differently.
TEST_F(FolderFramesTest, BordersThatOthersLackAreCutOff) {
  const auto marked = [&](const std::string& name, int width, int height) {  // a grid around the middle
    RgbImage image(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto level = [](int from_middle) { return static_cast<uint8_t>(128 + from_middle / 4); };
        image.at(x, y) = {level(x - width / 2), level(y - height / 2), 0};
      }
    write_file(folder_ / name, encode_png(image));
  };
  marked("a.png", 400, 299);
  marked("b.png", 402, 298);
  marked("c.png", 401, 299);
  marked("d.png", 420, 300);  // of another camera
  const FolderFrames frames(folder_);
  EXPECT_EQ(frames.working_size(), (ImageSize{400, 298}));
  EXPECT_EQ(frames.load(3).width, 420);
  const RgbImage first = frames.load(0);
  for (int i = 1; i < 3; ++i) EXPECT_EQ(frames.load(i), first) << i;
  Camera camera;
  camera.intrinsics = {804, 596, 600, 600, 402, 298};  // of the second, twice as large
  camera.name = "b.png";
  const std::vector<Camera> fitted = frames.fit({camera});
  ASSERT_EQ(fitted.size(), 1U);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.fx, 300);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.cx, 200);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.cy, 149);
  EXPECT_EQ(fitted[0].intrinsics.width, 400);

  const FolderFrames half(folder_, {200 * 149});
  EXPECT_EQ(half.working_size(), (ImageSize{200, 149}));
  for (int i = 1; i < 3; ++i) EXPECT_EQ(half.load(i), half.load(0)) << i;
  EXPECT_EQ(half.framing(1).left, 1);
  EXPECT_DOUBLE_EQ(half.fit({camera})[0].intrinsics.cx, 100);

  EXPECT_THROW(FolderFrames(folder_, {2'000'000, 1, false}), std::runtime_error);  // told that none is trimmed
  marked("b.png", 404, 300);                                                       // a hundredth is another camera's
  marked("d.png", 400, 299);
  EXPECT_EQ(FolderFrames(folder_).load(1).width, 404);
}

// Of the same shape, with more pixels than are worked on.
TEST_F(FolderFramesTest, CamerasOfPhotosThatAreScaledToTheSameSizeAreKept) {
  for (const char* const name : {"a.jpg", "b.jpg"}) photo(name, 200, 150);
  photo("c.jpg", 400, 300);
  Camera camera;
  camera.intrinsics = {400, 300, 300, 300, 200, 150};
  camera.name = "c.jpg";
  const std::vector<Camera> fitted = FolderFrames(folder_, {100 * 75}).fit({camera});
  ASSERT_EQ(fitted.size(), 1U);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.fx, 75);
}

// Scaled down to as many pixels as the others a crop of the same shape would pass for one of them.
TEST_F(FolderFramesTest, APhotoOfAnotherSizeIsScaledDownByAsMuchAsTheOthers) {
  for (const char* const name : {"a.jpg", "b.jpg"}) photo(name, 200, 150);
  photo("c.jpg", 100, 76);
  const FolderFrames frames(folder_, {50 * 38});
  EXPECT_EQ(frames.working_size(), (ImageSize{50, 37}));
  EXPECT_EQ(frames.load(2).width, 25);
  EXPECT_EQ(frames.load(2).height, 19);
}

TEST_F(FolderFramesTest, NamesATruncatedPhoto) {
  photo("a.jpg", 400, 300);
  std::vector<uint8_t> bytes = read_file(folder_ / "a.jpg");
  bytes.resize(bytes.size() / 2);
  write_file(folder_ / "b.jpg", bytes);
  EXPECT_THAT(refusal(), HasSubstr("b.jpg"));
}

TEST_F(FolderFramesTest, NamesAllDamagedPhotosAtOnce) {
  for (const char* const name : {"a.jpg", "b.jpg", "c.png", "d.jpg", "e.jpg", "f.jpg"}) photo(name);
  const auto cut = [&](const std::string& name) { fs::resize_file(folder_ / name, fs::file_size(folder_ / name) / 2); };
  const auto told = [&](const std::string& count, const std::string& names) {
    return folder_.string() + ": " + count + " of 6 photos are damaged (" + names +
           "): copy them again, or leave them out";
  };
  cut("b.jpg");
  EXPECT_THAT(refusal(), HasSubstr("b.jpg: damaged JPEG"));
  cut("c.png");
  EXPECT_EQ(refusal(), told("2", "b.jpg and c.png"));
  text("e.jpg", "no image, which its first bytes tell before any is decoded");
  EXPECT_EQ(refusal(), told("3", "b.jpg, c.png and e.jpg"));
  for (const char* const name : {"d.jpg", "f.jpg"}) cut(name);
  EXPECT_EQ(refusal(), told("5", "b.jpg, c.png, d.jpg, e.jpg and f.jpg"));
  for (int i = 10; i < 17; ++i) text("g" + std::to_string(i) + ".jpg", "none either");
  EXPECT_THAT(refusal(),
              HasSubstr(": 12 of 13 photos are damaged (b.jpg, c.png, d.jpg, e.jpg, f.jpg, g10.jpg, g11.jpg, "
                        "g12.jpg, g13.jpg, g14.jpg and 2 more): copy"));
}

TEST_F(FolderFramesTest, ScalesHugePhotosAndTheirCamerasToTheWorkingSize) {
  photo("a.jpg", 2000, 1000);
  const FolderFrames frames(folder_, {200 * 100});
  EXPECT_EQ(frames.stored_size(), (ImageSize{2000, 1000}));
  EXPECT_EQ(frames.working_size(), (ImageSize{200, 100}));
  const RgbImage image = frames.load(0);
  EXPECT_EQ(image.width, 200);
  EXPECT_EQ(image.height, 100);
  EXPECT_NEAR(image.at(100, 50).r, 90, 1);
  Camera camera;
  camera.name = "a.jpg";
  camera.intrinsics = {2000, 1000, 1500, 1500, 1000, 500, 0.1, 0, 0, 0};
  const std::vector<Camera> fitted = frames.fit({camera});
  ASSERT_EQ(fitted.size(), 1U);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.fx, 150);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.cy, 50);
  EXPECT_DOUBLE_EQ(fitted[0].intrinsics.k1, 0.1);
  EXPECT_EQ(fitted[0].intrinsics.width, 200);
}

TEST_F(FolderFramesTest, APhotoThatAnotherTookThePlaceOfIsRefused) {
  for (const int64_t pixels : {2'000'000, 1024}) {
    photo("a.jpg", 64, 48);
    const FolderFrames frames(folder_, {pixels});
    EXPECT_EQ(frames.load(0).width, frames.working_size().width);
    for (const ImageSize other : {ImageSize{48, 64}, ImageSize{20, 10}, ImageSize{640, 480}}) {
      photo("a.jpg", other.width, other.height);
      try {
        frames.load(0);
        ADD_FAILURE() << "a photo of another size was taken";
      } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), HasSubstr("a.jpg: is " + std::to_string(other.width) + "x"));
        EXPECT_THAT(error.what(), HasSubstr("by now and was 64x48"));
      }
    }
  }
}

TEST_F(FolderFramesTest, TurnsPhotosOfACameraOnItsSide) {
  RgbImage image(64, 32);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) image.at(x, y) = {255, 255, 255};  // a white corner, upper left
  write_file(folder_ / "a.png", encode_png(image));
  for (const int64_t pixels : {2'000'000, 1024}) {
    const auto corner = [&](int orientation) {
      const FolderFrames frames(folder_, {pixels, orientation});
      const RgbImage turned = frames.load(0);
      EXPECT_EQ((ImageSize{turned.width, turned.height}), frames.working_size());
      EXPECT_EQ(turned.height > turned.width, orientation != 3);
      const bool left = turned.at(1, 1).r + turned.at(1, turned.height - 2).r > 200;
      const bool above = turned.at(1, 1).r + turned.at(turned.width - 2, 1).r > 200;
      return std::string(above ? "upper " : "lower ") + (left ? "left" : "right");
    };
    EXPECT_EQ(corner(6), "upper right");
    EXPECT_EQ(corner(3), "lower right");
    EXPECT_EQ(corner(8), "lower left");
  }
  EXPECT_EQ(FolderFrames(folder_, {2'000'000, 6}).stored_size(), (ImageSize{32, 64}));
}

TEST_F(FolderFramesTest, LeavesOutCamerasWithoutAPhotoAndRefusesOtherShapes) {
  photo("a.jpg");
  const FolderFrames frames(folder_);
  Camera camera;
  camera.intrinsics = {40, 30, 50, 50, 20, 15, 0, 0, 0, 0};
  camera.name = "elsewhere.jpg";
  EXPECT_TRUE(frames.fit({camera}).empty());
  camera.name = "a.jpg";
  camera.intrinsics.height = 40;
  EXPECT_THROW(frames.fit({camera}), std::runtime_error);
}

TEST_F(FolderFramesTest, ReadsWhatTheCaptureSays) {
  EXPECT_FALSE(read_capture_notes(folder_).arm_length);
  text("capture.json",
       R"({"arm_length": 0.7, "device": "board", "begin_utc": "2026-01-01T00:00:00Z", "fov_degrees": 60})");
  const CaptureNotes notes = read_capture_notes(folder_);
  EXPECT_EQ(notes.arm_length, 0.7);
  EXPECT_EQ(notes.device, "board");
  EXPECT_NEAR(*notes.fov_rad, 1.0472, 1e-4);
  text("capture.json", R"({"fov_degrees": 0})");
  EXPECT_FALSE(read_capture_notes(folder_).fov_rad) << "it is unknown";
  text("capture.json", "{\"arm_length\":");
  EXPECT_THROW(read_capture_notes(folder_), std::runtime_error);
}

TEST_F(FolderFramesTest, AFieldOfViewThatNoCameraHasIsRefusedByItsFileAndName) {
  for (const char* const degrees : {"5", "150"}) {
    text("capture.json", std::string("{\"fov_degrees\": ") + degrees + "}");
    EXPECT_TRUE(read_capture_notes(folder_).fov_rad) << degrees;
  }
  for (const char* const degrees : {"200", "0.5", "4.5", "151"}) {
    text("capture.json", std::string("{\"fov_degrees\": ") + degrees + "}");
    try {
      read_capture_notes(folder_, "a.zip");
      ADD_FAILURE() << degrees;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), std::string("a.zip: capture.json: fov_degrees is ") + degrees +
                                  ", expected 5 to 150: correct it, or remove it to do without");
    }
  }
}

TEST(NaturalOrder, ComparesNumbersByValueAndTheRestByLetters) {
  EXPECT_TRUE(precedes_naturally("frame_9.jpg", "frame_10.jpg"));
  EXPECT_FALSE(precedes_naturally("frame_10.jpg", "frame_9.jpg"));
  EXPECT_TRUE(precedes_naturally("a", "b"));
  EXPECT_TRUE(precedes_naturally("a", "a1"));
  EXPECT_TRUE(precedes_naturally("a01", "a1") != precedes_naturally("a1", "a01"));
  EXPECT_FALSE(precedes_naturally("a1", "a1"));
}

TEST(ResizeByArea, AveragesExactly) {
  RgbImage image(4, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) image.at(x, y) = {static_cast<uint8_t>(10 * x + 100 * y), 0, 255};
  }
  const RgbImage half = resize_by_area(image, 2, 1);
  EXPECT_EQ(half.at(0, 0), (Rgb{55, 0, 255}));
  EXPECT_EQ(half.at(1, 0), (Rgb{75, 0, 255}));
  const RgbImage thirds = resize_by_area(image, 3, 2);  // pixel 0 covers 1 and a third of its source
  EXPECT_EQ(thirds.at(0, 0).r, 3);                      // (0 * 3 + 10 * 1) / 4 = 2.5
  GreyImage grey(4, 2);
  std::transform(image.samples.begin(), image.samples.end(), grey.samples.begin(), [](const Rgb& p) { return p.r; });
  EXPECT_EQ(resize_by_area(grey, 2, 1).samples, (Samples<uint8_t>{55, 75}));
  EXPECT_THROW(resize_by_area(image, 5, 1), std::logic_error);
}

}  // namespace
}  // namespace ldp
