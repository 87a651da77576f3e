// One sweep of a camera that hands out what it is given.
#include "device/service/sweep_run.h"

#include <gmock/gmock.h>
#include <stdlib.h>

#include <deque>
#include <fstream>
#include <iterator>

#include "core/photos/images.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 192, kHeight = 144;
constexpr int64_t kInterval_ns = 33'000'000;

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class GivenCamera : public CameraDevice {
 public:
  explicit GivenCamera(std::deque<CameraFrame>& frames) : frames_(frames) {}
  std::string name() const override { return "given"; }
  CameraMode mode() const override { return {PixelFormat::mjpeg, kWidth, kHeight, 30, 0}; }
  void start() override {}
  void stop() override {}
  int fd() const override { return -1; }
  std::optional<CameraFrame> read() override {
    if (frames_.empty()) return std::nullopt;
    CameraFrame frame = std::move(frames_.front());
    frames_.pop_front();
    return frame;
  }
  bool lock_exposure(bool /*locked*/) override { return false; }

 private:
  std::deque<CameraFrame>& frames_;
};

// A landscape that moves to the left by `offset_px`.
RgbImage view(int offset_px, int width, int height) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const unsigned cell =
          static_cast<unsigned>((x + offset_px) / 8) * 2654435761U ^ static_cast<unsigned>(y / 8) * 40503U;
      const auto grey = static_cast<uint8_t>(60 + (cell >> 13) % 120);
      image.at(x, y) = {grey, grey, grey};
    }
  }
  return image;
}

class SweepRunTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_sweep_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  // As the driver gives them: it knows the size that was agreed on, not what the file's header says.
  void give_jpeg(const RgbImage& image) {
    auto bytes = std::make_shared<const std::vector<uint8_t>>(encode_jpeg(image, 95));
    CameraFrame& frame = next_frame();
    frame.format = PixelFormat::mjpeg;
    frame.width = kWidth, frame.height = kHeight;
    frame.planes = {{bytes->data(), bytes->size(), 0}};
    frame.lease = std::move(bytes);
  }
  void give_pixels(RgbImage image) {
    auto pixels = std::make_shared<const RgbImage>(std::move(image));
    CameraFrame& frame = next_frame();
    frame.format = PixelFormat::rgb24;
    frame.width = pixels->width, frame.height = pixels->height;
    frame.planes = {{&pixels->samples.data()->r, pixels->samples.size() * sizeof(Rgb), pixels->width * 3}};
    frame.lease = std::move(pixels);
  }
  int take_all() {
    fs::remove_all(folder_);
    fs::create_directory(folder_);
    FrameWriter writer;
    SweepRun sweep(Config(), std::make_unique<GivenCamera>(frames_), folder_, writer);
    while (!frames_.empty()) sweep.read_frame();
    return sweep.chosen();
  }

  std::vector<ImageSize> recorded_sizes() const {
    std::vector<ImageSize> sizes;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (entry.path().extension() == ".jpg") sizes.push_back(read_image_size(entry.path()));
    }
    return sizes;
  }

  fs::path folder_;
  std::deque<CameraFrame> frames_;

 private:
  CameraFrame& next_frame() {
    CameraFrame& frame = frames_.emplace_back();
    frame.sequence = static_cast<int64_t>(frames_.size());
    frame.time_ns = frame.sequence * kInterval_ns;
    return frame;
  }
};

TEST_F(SweepRunTest, AJpegWhoseHeaderTellsAnotherSizeIsSkippedAndTheSweepGoesOn) {
  for (int i = 0; i < 4; ++i) give_jpeg(view(i * 64, kWidth, kHeight));
  const int without = take_all();
  EXPECT_GE(without, 3);
  for (int i = 0; i < 4; ++i) {
    give_jpeg(view(i * 64, kWidth, kHeight));
    give_jpeg(view(i * 64 + 8, kWidth, kHeight / 2));
  }
  EXPECT_EQ(take_all(), without);
}

// Its height is wrong by so little that the thumbnails are alike, or by half.
TEST_F(SweepRunTest, AFirstJpegWhoseHeaderTellsAnotherSizeDecidesNothing) {
  for (int i = 0; i < 4; ++i) give_jpeg(view(i * 64, kWidth, kHeight));
  const int without = take_all();
  for (const int height : {kHeight + 1, kHeight / 2}) {
    for (int i = 0; i < 2; ++i) give_jpeg(view(0, kWidth, height));
    for (int i = 0; i < 4; ++i) give_jpeg(view(i * 64, kWidth, kHeight));
    EXPECT_EQ(take_all(), without) << height;
    EXPECT_THAT(recorded_sizes(), testing::Each(ImageSize{kWidth, kHeight}));
  }
}

// As some cameras do, whose driver agreed on 1080 rows.
TEST_F(SweepRunTest, ACameraWhoseFramesAllHaveAnotherSizeThanWasAgreedOnIsBelieved) {
  for (int i = 0; i < 8; ++i) give_jpeg(view(i * 64, kWidth, kHeight + 8));
  EXPECT_GE(take_all(), 5);
  EXPECT_THAT(recorded_sizes(), testing::Each(ImageSize{kWidth, kHeight + 8}));
  std::string told = "\"height\": ";
  told += std::to_string(kHeight + 8);
  EXPECT_THAT(text_of(folder_ / "capture.json"), testing::HasSubstr(told));
}

// Wider than a JPEG can be.
TEST_F(SweepRunTest, AFirstFrameThatCannotBeStoredEndsNoSweep) {
  give_pixels(view(0, 70000, 8));
  for (int i = 0; i < 3; ++i) give_jpeg(view(i * 64, kWidth, kHeight));
  EXPECT_GE(take_all(), 2);
}

}  // namespace
}  // namespace ldp
