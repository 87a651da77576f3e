#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/captures/field_of_view.h"
#include "core/photos/images.h"
#include "device/capture/frame_pixels.h"
#include "device/capture/frame_selection.h"
#include "device/capture/image_shift.h"

namespace ldp {
namespace {

// A wide random landscape: smooth noise of several sizes, closed into a ring.
GreyImage landscape(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Plane<float> sum(width, height, 128.0F);
  for (const int cell : {3, 8, 20}) {
    Plane<float> noise(width / cell + 2, height / cell + 2);
    for (float& value : noise.samples) value = static_cast<float>(random() % 1000) / 1000.0F - 0.5F;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const float fx = static_cast<float>(x) / static_cast<float>(cell),
                    fy = static_cast<float>(y) / static_cast<float>(cell);
        const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
        const float a = fx - static_cast<float>(ix), b = fy - static_cast<float>(iy);
        const float top = noise.at(ix, iy) * (1 - a) + noise.at(ix + 1, iy) * a;
        const float bottom = noise.at(ix, iy + 1) * (1 - a) + noise.at(ix + 1, iy + 1) * a;
        sum.at(x, y) += 90.0F * (top * (1 - b) + bottom * b);
      }
    }
  }
  GreyImage image(width, height);
  for (size_t i = 0; i < image.samples.size(); ++i) {
    image.samples[i] = static_cast<uint8_t>(std::min(255.0F, std::max(0.0F, sum.samples[i])));
  }
  return image;
}

GreyImage window_of(const GreyImage& from, int x, int y, int width = 96, int height = 72) {
  GreyImage image(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image.at(u, v) = from.at((x + u) % from.width, std::min(y + v, from.height - 1));
  }
  return image;
}

struct Kept {
  std::vector<double> positions;  // pixels of the landscape
  std::vector<double> sharpness;
  Guidance last;
};

// A camera that looks at position(i) of the landscape in its i-th frame.
template <typename Position, typename Sharpness>
Kept sweep_over(int frames, double fps, Position position, Sharpness sharpness, ChooserOptions options = {}) {
  const GreyImage world = landscape(4000, 100, 7);
  FrameChooser chooser(options);
  Kept kept;
  int held = -1;
  const auto keep = [&](int i) {
    kept.positions.push_back(position(i));
    kept.sharpness.push_back(sharpness(i));
  };
  for (int i = 0; i < frames && !chooser.full(); ++i) {
    OfferedFrame frame{
        window_of(world, static_cast<int>(position(i)), 10), sharpness(i), static_cast<int64_t>(i * 1e9 / fps), {}};
    const Verdict verdict = chooser.offer(frame);
    if (verdict.store_held) keep(held);
    if (verdict.store_held || verdict.store_this) held = -1;
    if (verdict.store_this) keep(i);
    if (verdict.hold_this) held = i;
  }
  if (chooser.finish()) keep(held);
  kept.last = chooser.guidance();
  return kept;
}

constexpr auto kAllSharp = [](int) { return 1.0; };

TEST(FrameChoice, EveryFieldOfViewThatCanBeToldIsTaken) {
  for (const double degrees : {kLeastFov_deg, kMostFov_deg}) {
    ChooserOptions options;
    options.fov_rad = degrees * std::numbers::pi / 180;
    EXPECT_NO_THROW(FrameChooser{options}) << degrees;
  }
}

TEST(Motion, AShiftOfTheWindowIsFoundToAFractionOfAPixel) {
  const GreyImage world = landscape(600, 120, 3);
  const GreyImage first = window_of(world, 200, 20);
  for (const int dx : {0, 1, 7, 24, 40, -13, -37}) {
    for (const int dy : {0, 3, -6}) {
      const Shift shift = estimate_shift(first, window_of(world, 200 + dx, 20 + dy));
      EXPECT_NEAR(shift.dx_px, -dx, 0.3) << dx << " " << dy;
      EXPECT_NEAR(shift.dy_px, -dy, 0.3) << dx << " " << dy;
      EXPECT_GT(shift.match, 0.8);
    }
  }
}

TEST(Motion, BrightnessAndContrastDoNotMatter) {
  const GreyImage world = landscape(600, 120, 3);
  GreyImage second = window_of(world, 215, 20);
  for (uint8_t& sample : second.samples) sample = static_cast<uint8_t>(sample / 2 + 90);
  EXPECT_NEAR(estimate_shift(window_of(world, 200, 20), second).dx_px, -15, 0.3);
}

TEST(Motion, PicturesOfDifferentThingsDoNotMatch) {
  const GreyImage one = landscape(96, 72, 1), other = landscape(96, 72, 2);
  EXPECT_LT(estimate_shift(one, other).match, 0.35);
}

TEST(FrameChoice, NeighboursOverlapByTheWantedShareAtAnySpeed) {
  for (const double px_per_frame : {0.5, 1.0, 2.0, 4.0, 7.0}) {
    const auto position = [&](int i) { return 100 + std::floor(i * px_per_frame); };
    const Kept kept = sweep_over(static_cast<int>(400 / px_per_frame), 30, position, kAllSharp);
    ASSERT_GE(kept.positions.size(), 16U) << px_per_frame;
    ASSERT_LE(kept.positions.size(), 26U) << px_per_frame;
    for (size_t i = 1; i < kept.positions.size(); ++i) {
      const double step = (kept.positions[i] - kept.positions[i - 1]) / 96;
      EXPECT_LE(step, 0.25 + 0.02) << px_per_frame;
      EXPECT_GE(step, 0.1) << px_per_frame;
    }
  }
}

TEST(FrameChoice, AWavyArmSpeedStillGivesEvenFrames) {
  const auto position = [](int i) { return 100 + std::floor(2.0 * i + 20 * std::sin(i * 0.08)); };
  const Kept kept = sweep_over(200, 30, position, kAllSharp);
  for (size_t i = 1; i < kept.positions.size(); ++i) EXPECT_LE(kept.positions[i] - kept.positions[i - 1], 26);
}

TEST(FrameChoice, OfTheFramesThatWouldDoTheSharpestIsKept) {
  const auto sharp = [](int i) { return i % 5 == 0 ? 2.0 : 1.0; };
  const Kept kept = sweep_over(
      300, 30, [](int i) { return 100.0 + i; }, sharp);
  ASSERT_GE(kept.positions.size(), 10U);
  for (size_t i = 1; i + 1 < kept.sharpness.size(); ++i) EXPECT_EQ(kept.sharpness[i], 2.0) << i;
}

TEST(FrameChoice, ACameraAtRestGivesOneFrame) {
  EXPECT_EQ(sweep_over(
                100, 30, [](int) { return 100.0; }, kAllSharp)
                .positions.size(),
            1U);
}

TEST(FrameChoice, EveryFrameIsKeptWhenTheyAreFartherApartThanWanted) {
  const Kept kept = sweep_over(
      12, 30, [](int i) { return 100.0 + 36 * i; }, kAllSharp);
  EXPECT_EQ(kept.positions.size(), 12U);
}

TEST(FrameChoice, PhotosThatAlreadyOverlapAsWantedAreAllKept) {
  const Kept kept = sweep_over(
      20, 30, [](int i) { return 100.0 + 16 * i; }, kAllSharp);
  EXPECT_EQ(kept.positions.size(), 20U);
}

// Steps that still overlap, that overlap too little to be matched, and that show something else altogether.
TEST(FrameChoice, AHandThatRestsAndJumpsLosesNoPicture) {
  for (const int jump_px : {16, 30, 70, 200}) {
    const auto position = [&](int i) { return 100.0 + jump_px * (i / 6); };
    EXPECT_EQ(sweep_over(19 * 6, 30, position, kAllSharp).positions.size(), 19U) << jump_px;
  }
}

TEST(FrameChoice, AfterAJumpFromRestTheFirstClearFramesAreKeptAndTheSweepGoesOn) {
  const auto position = [](int i) { return i < 20 ? 100.0 : 300.0 + (i - 20); };
  const Kept kept = sweep_over(120, 30, position, kAllSharp);
  ASSERT_GE(kept.positions.size(), 4U);
  EXPECT_LE(kept.positions[1], 304);
  for (size_t i = 2; i < kept.positions.size(); ++i) EXPECT_LE(kept.positions[i] - kept.positions[i - 1], 26);
}

TEST(FrameChoice, APictureAfterAJumpInMidSweepIsKeptOnce) {
  for (const int px_per_frame : {1, 2, 3, 4, 5}) {
    const auto position = [&](int i) { return i < 4 ? 100.0 + px_per_frame * i : 300.0; };
    EXPECT_EQ(sweep_over(60, 30, position, kAllSharp).positions.size(), 2U) << px_per_frame;
  }
}

TEST(FrameChoice, AJumpThatNothingIsKnownOfDoesNotDecideTheDirection) {
  for (int jump_px = 150; jump_px <= 400; jump_px += 25) {
    const auto position = [&](int i) { return i < 10 ? 100.0 : 100.0 + jump_px + 2 * (i - 10); };
    const Kept kept = sweep_over(80, 30, position, kAllSharp);
    EXPECT_GE(kept.positions.size(), 7U) << jump_px;
    EXPECT_NE(kept.last.advice, Advice::turn_back) << jump_px;
  }
}

TEST(FrameChoice, ASmearedFrameIsNoJump) {
  const GreyImage world = landscape(1000, 100, 7), smear(96, 72, 90);
  FrameChooser chooser({});
  int kept = 0;
  for (int i = 0; i < 60; ++i) {
    const Verdict verdict = chooser.offer({i % 10 == 5 ? smear : window_of(world, 100, 10), 1, i * 33'000'000LL, {}});
    kept += verdict.store_held + verdict.store_this;
  }
  EXPECT_EQ(kept, 1);
}

TEST(FrameChoice, ASweepToTheLeftWorksAsOneToTheRight) {
  const Kept kept = sweep_over(
      200, 30, [](int i) { return 900.0 - 2 * i; }, kAllSharp);
  EXPECT_GE(kept.positions.size(), 16U);
  EXPECT_GT(kept.last.covered_rad, 0);
}

TEST(FrameChoice, GoingBackKeepsNothingTwiceAndIsTold) {
  const auto position = [](int i) { return i < 100 ? 500.0 + i : 600.0 - (i - 100); };
  const Kept forth = sweep_over(100, 30, position, kAllSharp);
  const Kept back = sweep_over(150, 30, position, kAllSharp);
  EXPECT_LE(back.positions.size(), forth.positions.size() + 1);
  EXPECT_EQ(back.last.advice, Advice::turn_back);
}

TEST(FrameChoice, TheSweepIsFullAtTheMostFrames) {
  ChooserOptions options;
  options.max_frames = 8;
  const Kept kept = sweep_over(
      400, 30, [](int i) { return 100.0 + 4 * i; }, kAllSharp, options);
  EXPECT_EQ(kept.positions.size(), 8U);
  EXPECT_EQ(kept.last.advice, Advice::done);
}

// Where a sweep over a world that closes after `round_px` ends, in pixels; the upper half of the picture is far, the
// lower passes `parallax` times as fast.
double end_of_turn(int round_px, int parallax, double px_per_frame, unsigned seed, ChooserOptions options = {}) {
  const GreyImage far = landscape(round_px, 100, seed), near = landscape(round_px * parallax, 100, seed + 1);
  options.max_frames = 1000;
  FrameChooser chooser(options);
  for (double at = 0; at < 2.5 * round_px; at += px_per_frame) {
    GreyImage view = window_of(far, static_cast<int>(at), 10);
    const GreyImage below = window_of(near, static_cast<int>(at) * parallax, 10);
    std::copy(below.row(36), below.row(0) + below.samples.size(), view.row(36));
    chooser.offer({std::move(view), 1, static_cast<int64_t>(at / px_per_frame * 33e6), {}});
    if (chooser.full()) return at;
  }
  return 0;
}

TEST(FrameChoice, ATurnIsOverWhenTheFirstFrameComesIntoViewAgainWhateverTheAnglesSay) {
  for (const int parallax : {1, 2}) {
    for (const int round_px : {475, 700, 1100}) {
      for (const double px_per_frame : {2.0, 5.0}) {
        const double end = end_of_turn(round_px, parallax, px_per_frame, 40);
        EXPECT_GE(end, round_px - 10) << parallax << " " << round_px << " " << px_per_frame;
        EXPECT_LE(end, round_px + 10) << parallax << " " << round_px << " " << px_per_frame;
      }
    }
  }
}

TEST(FrameChoice, NoAngleEndsASweepThatHasNotComeRound) {
  ChooserOptions options;
  options.max_frames = 1000;
  const Kept kept = sweep_over(
      1250, 30, [](int i) { return 3.0 * i; }, kAllSharp, options);
  EXPECT_GT(kept.last.covered_rad, 40);
  EXPECT_NE(kept.last.advice, Advice::done);
}

TEST(FrameChoice, OneLookAlikeDoesNotEndASweep) {
  const GreyImage world = landscape(4000, 100, 7);
  FrameChooser chooser({});
  for (int i = 0; i < 400; ++i) {
    chooser.offer({window_of(world, i % 50 == 49 ? 0 : 2 * i, 10), 1, i * 33'000'000LL, {}});
    ASSERT_FALSE(chooser.full()) << i;
  }
}

TEST(FrameChoice, AnArmThatIsTooFastIsToldToSlowDown) {
  const Kept kept = sweep_over(
      40, 30, [](int i) { return 100.0 + 8 * i; }, kAllSharp);
  EXPECT_EQ(kept.last.advice, Advice::slower);
}

TEST(FrameChoice, AnArmThatRestsIsToldToGoOn) {
  const Kept kept = sweep_over(
      150, 30, [](int i) { return i < 60 ? 100.0 + i : 160.0; }, kAllSharp);
  EXPECT_EQ(kept.last.advice, Advice::faster);
}

TEST(FrameChoice, DarknessIsTold) {
  FrameChooser chooser({});
  chooser.offer({GreyImage(96, 72, 3), 1, 0, {}});
  EXPECT_EQ(chooser.guidance().advice, Advice::too_dark);
}

TEST(FrameChoice, ATiltedArmIsTold) {
  const GreyImage world = landscape(1000, 140, 5);
  FrameChooser chooser({});
  for (int i = 0; i < 60; ++i) chooser.offer({window_of(world, 100 + i, 20 + i / 3), 1, i * 33'000'000LL, {}});
  EXPECT_EQ(chooser.guidance().advice, Advice::level);
  EXPECT_LT(chooser.guidance().tilt_px, -10);
}

// --- pixels ----------------------------------------------------------------------------------------------------------

CameraFrame frame_over(const std::vector<uint8_t>& bytes, PixelFormat format, int width, int height, int stride) {
  CameraFrame frame;
  frame.format = format;
  frame.width = width;
  frame.height = height;
  frame.planes = {{bytes.data(), bytes.size(), stride}};
  return frame;
}

TEST(FramePixels, AJpegFrameIsStoredByteByByte) {
  const std::vector<uint8_t> jpeg = encode_jpeg(RgbImage(64, 48, Rgb{200, 100, 50}), 90);
  EXPECT_EQ(jpeg_from(frame_over(jpeg, PixelFormat::mjpeg, 64, 48, 0)), jpeg);
}

TEST(FramePixels, EveryRawFormatBecomesTheSamePicture) {
  constexpr int kWidth = 32, kHeight = 16, kPadding = 12;
  const Rgb colour{180, 90, 60};
  const int y = (299 * colour.r + 587 * colour.g + 114 * colour.b) / 1000;
  const auto u = static_cast<uint8_t>(128 + (colour.b - y) * 564 / 1000),
             v = static_cast<uint8_t>(128 + (colour.r - y) * 713 / 1000);
  const auto luma = static_cast<uint8_t>(y);
  std::vector<uint8_t> rgb, bgr, yuyv, nv12_luma((kWidth + kPadding) * kHeight, luma), nv12_chroma;
  for (int row = 0; row < kHeight; ++row) {
    for (int x = 0; x < kWidth; ++x) {
      rgb.insert(rgb.end(), {colour.r, colour.g, colour.b});
      bgr.insert(bgr.end(), {colour.b, colour.g, colour.r});
      yuyv.insert(yuyv.end(), {luma, x % 2 == 0 ? u : v});
    }
    for (auto* plane : {&rgb, &bgr, &yuyv}) plane->insert(plane->end(), kPadding, 7);
  }
  for (int i = 0; i < (kWidth + kPadding) / 2 * kHeight / 2; ++i) nv12_chroma.insert(nv12_chroma.end(), {u, v});
  CameraFrame nv12 = frame_over(nv12_luma, PixelFormat::nv12, kWidth, kHeight, kWidth + kPadding);
  nv12.planes.push_back({nv12_chroma.data(), nv12_chroma.size(), kWidth + kPadding});
  const CameraFrame frames[] = {frame_over(rgb, PixelFormat::rgb24, kWidth, kHeight, 3 * kWidth + kPadding),
                                frame_over(bgr, PixelFormat::bgr24, kWidth, kHeight, 3 * kWidth + kPadding),
                                frame_over(yuyv, PixelFormat::yuyv, kWidth, kHeight, 2 * kWidth + kPadding), nv12};
  for (const CameraFrame& frame : frames) {
    const RgbImage image = decode_image(jpeg_from(frame), name_of(frame.format));
    for (const Rgb& pixel : image.samples) {
      ASSERT_NEAR(pixel.r, colour.r, 6) << name_of(frame.format);
      ASSERT_NEAR(pixel.g, colour.g, 6) << name_of(frame.format);
      ASSERT_NEAR(pixel.b, colour.b, 6) << name_of(frame.format);
    }
    EXPECT_NEAR(thumbnail(frame).samples[0],
                frame.format == PixelFormat::rgb24 || frame.format == PixelFormat::bgr24 ? 90 : y, 1);
  }
}

TEST(FramePixels, ABlurredFrameIsLessSharp) {
  std::mt19937 random(1);
  std::vector<uint8_t> noise(64 * 48 * 2);
  for (uint8_t& sample : noise) sample = static_cast<uint8_t>(random());
  std::vector<uint8_t> blurred = noise;
  for (size_t i = 8; i < noise.size(); i += 2)
    blurred[i] = static_cast<uint8_t>((noise[i] + noise[i - 2] + noise[i - 4]) / 3);
  EXPECT_GT(sharpness(frame_over(noise, PixelFormat::yuyv, 64, 48, 128)),
            1.3 * sharpness(frame_over(blurred, PixelFormat::yuyv, 64, 48, 128)));
}

TEST(FramePixels, ADamagedJpegIsRefusedInWords) {
  std::vector<uint8_t> jpeg =
      encode_jpeg(landscape(64, 48, 1).empty() ? RgbImage() : RgbImage(64, 48, Rgb{1, 2, 3}), 90);
  jpeg.resize(jpeg.size() / 4);
  EXPECT_THROW(thumbnail(frame_over(jpeg, PixelFormat::mjpeg, 64, 48, 0)), std::runtime_error);
}

}  // namespace
}  // namespace ldp
