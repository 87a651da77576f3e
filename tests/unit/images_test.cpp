#include "core/photos/images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "core/base/files.h"
#include "core/photos/halved.h"
#include "tests/unit/rms.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using test::rms;
using ::testing::HasSubstr;

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("ldp_images_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

// Smooth in x and y, a step in the middle.
RgbImage some_image(int width, int height) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = {static_cast<uint8_t>(x * 255 / width), static_cast<uint8_t>(y * 255 / height),
                        static_cast<uint8_t>(x < width / 2 ? 40 : 200)};
  return image;
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "no error";
}

// A little-endian EXIF block with orientation and 35 mm focal length.
std::vector<uint8_t> exif(uint8_t orientation, uint8_t focal_35mm) {
  return {'E', 'x', 'i', 'f',         0,    0,    'I', 'I',  42,   0, 8, 0, 0,          0, 2, 0,  0x12, 0x01, 3, 0, 1,
          0,   0,   0,   orientation, 0,    0,    0,   0x69, 0x87, 4, 0, 1, 0,          0, 0, 38, 0,    0,    0, 0, 0,
          0,   0,   1,   0,           0x05, 0xA4, 3,   0,    1,    0, 0, 0, focal_35mm, 0, 0, 0,  0,    0,    0, 0};
}

TEST(Png, KeepsEveryPixel) {
  std::mt19937 random(3);
  RgbImage image(37, 21);
  for (Rgb& c : image.samples)
    c = {static_cast<uint8_t>(random()), static_cast<uint8_t>(random()), static_cast<uint8_t>(random())};
  EXPECT_EQ(decode_image(encode_png(image), "a"), image);
  EXPECT_EQ(decode_image(encode_png(image, Plane<uint8_t>(37, 21, 7)), "a"), image)
      << "transparency is dropped, not mixed in";
}

TEST(Png, TellsTheSoftwareThatWroteIt) {
  const RgbImage image = some_image(16, 12);
  const Plane<uint8_t> alpha(16, 12, 7);
  EXPECT_EQ(png_software(encode_png(image, alpha, "a program")), "a program");
  EXPECT_EQ(decode_image(encode_png(image, alpha, "a program"), "a"), image);
  EXPECT_EQ(png_software(encode_png(image, alpha)), "");
  const std::vector<uint8_t> bytes = encode_png(image, alpha, "a program");
  EXPECT_EQ(png_software(std::span(bytes).first(50)), "");
  EXPECT_EQ(png_software(encode_jpeg(image, 90)), "");
}

TEST(Png, GreyIsReadAsThreeEqualChannelsAndSixteenBitsAreRounded) {
  Plane<uint16_t> grey(2, 1);
  grey.samples = {0x1234, 0xFFFF};
  const RgbImage back = decode_image(encode_png(grey), "a");
  EXPECT_EQ(back.at(0, 0), (Rgb{0x12, 0x12, 0x12}));
  EXPECT_EQ(back.at(1, 0), (Rgb{255, 255, 255}));
}

TEST(Jpeg, IsCloseAndCloserAtHigherQuality) {
  const RgbImage image = some_image(160, 120);
  const double at_75 = rms(decode_image(encode_jpeg(image, 75), "a"), image);
  const double at_95 = rms(decode_image(encode_jpeg(image, 95), "a"), image);
  EXPECT_LT(at_75, 6);
  EXPECT_LT(at_95, at_75);
}

TEST(Jpeg, EveryEarlyEndIsAnErrorThatNamesTheFile) {
  const std::vector<uint8_t> bytes = encode_jpeg(some_image(64, 48), 80);
  for (size_t length = 0; length + 2 < bytes.size(); ++length) {
    const std::string message = message_of([&] { decode_image(std::span(bytes).first(length), "leaf.jpg"); });
    ASSERT_THAT(message, HasSubstr("leaf.jpg: ")) << length;
  }
}

// A grey progressive JPEG of which every scan says in a few bytes that all blocks are zero.
std::vector<uint8_t> jpeg_of_empty_scans(uint16_t side, int scans) {
  std::vector<uint8_t> bytes = {0xFF, 0xD8};
  const auto segment = [&](uint8_t marker, const std::vector<uint8_t>& content) {
    bytes.insert(bytes.end(), {0xFF, marker, 0, static_cast<uint8_t>(content.size() + 2)});
    bytes.insert(bytes.end(), content.begin(), content.end());
  };
  std::vector<uint8_t> quantisation(65, 1), code(18, 0);
  quantisation[0] = 0;
  segment(0xDB, quantisation);
  const auto high = static_cast<uint8_t>(side >> 8), low = static_cast<uint8_t>(side & 255);
  segment(0xC2, {8, high, low, high, low, 1, 1, 0x11, 0});
  code[0] = 0x10, code[1] = 1, code[17] = 0xE0;  // one code: the next 16384 blocks and more are at their end
  segment(0xC4, code);
  const int runs = (side / 8) * (side / 8) / (1 << 14);
  for (int i = 0; i < scans; ++i) {
    segment(0xDA, {1, 1, 0, 1, 63, 0});
    bytes.insert(bytes.end(), static_cast<size_t>(2 * runs), 0);  // 15 bits each
  }
  bytes.insert(bytes.end(), {0xFF, 0xD9});
  return bytes;
}

TEST(Jpeg, ManyScansOfManyPixelsInFewBytesAreRefused) {
  EXPECT_EQ(decode_image(jpeg_of_empty_scans(1024, 100), "a.jpg").width, 1024);
  EXPECT_THAT(message_of([&] { decode_image(jpeg_of_empty_scans(4096, 100), "a.jpg"); }),
              HasSubstr("a.jpg: damaged JPEG (too many scans)"));
}

TEST(Png, EveryEarlyEndIsAnErrorThatNamesTheFile) {
  const std::vector<uint8_t> bytes = encode_png(some_image(16, 12));
  for (size_t length = 0; length < bytes.size(); ++length)
    ASSERT_THAT(message_of([&] { decode_image(std::span(bytes).first(length), "leaf.png"); }), HasSubstr("leaf.png: "))
        << length;
}

TEST(Webp, IsExactWithoutLossAndCloseWithLoss) {
  const RgbImage image = some_image(160, 121);
  EXPECT_EQ(decode_image(encode_webp_lossless(image), "a"), image);
  EXPECT_EQ(image_size(encode_webp(image, 80), "a"), (ImageSize{160, 121}));
  EXPECT_LT(rms(decode_image(encode_webp(image, 80), "a"), image), 6);
}

TEST(Webp, EveryEarlyEndIsAnErrorThatNamesTheFile) {
  for (const std::vector<uint8_t>& bytes :
       {encode_webp(some_image(64, 48), 80), encode_webp_lossless(some_image(64, 48))})
    for (size_t length = 0; length + 1 < bytes.size(); ++length)
      ASSERT_THAT(message_of([&] { decode_image(std::span(bytes).first(length), "leaf.webp"); }),
                  HasSubstr("leaf.webp: "))
          << length;
}

TEST(Images, RandomDamageNeverDoesMoreThanThrow) {
  std::mt19937 random(11);
  for (std::vector<uint8_t> sound : {encode_jpeg(some_image(40, 30), 80), encode_png(some_image(40, 30))})
    for (int i = 0; i < 3000; ++i) {
      std::vector<uint8_t> bytes = sound;
      // Leave the size fields alone: a huge but lawful size is only slow.
      const size_t header = bytes[0] == 0xFF ? 200 : 33;
      bytes[header + random() % (bytes.size() - header)] ^= static_cast<uint8_t>(1 + random() % 255);
      try {
        const RgbImage image = decode_image(bytes, "a");
        EXPECT_LE(image.samples.size(), size_t{1} << 20);
      } catch (const std::runtime_error&) {
      }
    }
}

TEST(Images, SomethingElseIsNamedAsSuch) {
  const std::vector<uint8_t> text = {'h', 'e', 'l', 'l', 'o'};
  EXPECT_EQ(message_of([&] { decode_image(text, "notes.txt"); }),
            "notes.txt: neither a JPEG nor a PNG nor a WebP file: copy it again, or leave it out");
}

TEST(Images, ACutPhotoIsNamedWithWhatToDo) {
  const RgbImage image = some_image(64, 48);
  for (std::vector<uint8_t> bytes : {encode_jpeg(image, 80), encode_png(image), encode_webp(image, 80)}) {
    bytes.resize(bytes.size() / 2);
    const std::string message = message_of([&] { decode_image(bytes, "a.photo"); });
    EXPECT_TRUE(message.starts_with("a.photo: damaged ")) << message;
    EXPECT_TRUE(message.ends_with("): copy it again, or leave it out")) << message;
  }
}

TEST(Images, ASizeBeyondTheLimitsIsRefusedBeforeAnythingIsAllocated) {
  std::vector<uint8_t> bytes = encode_jpeg(some_image(16, 16), 80);
  const std::array<uint8_t, 2> start_of_frame = {0xFF, 0xC0};
  const auto sof = std::search(bytes.begin(), bytes.end(), start_of_frame.begin(), start_of_frame.end());
  ASSERT_NE(sof, bytes.end());
  for (int i = 5; i < 9; ++i) sof[i] = 0xFF;
  EXPECT_THAT(message_of([&] { decode_image(bytes, "big.jpg"); }), HasSubstr("big.jpg: "));
}

TEST(Photo, OrientationAndFocalLengthComeFromExif) {
  const Folder folder;
  const RgbImage stored = some_image(48, 32);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const JpegSegment segment{0xE1, exif(static_cast<uint8_t>(orientation), 36)};
    write_file(folder / "a.jpg", encode_jpeg(stored, 100, {&segment, 1}));
    const Photo photo = read_photo(folder / "a.jpg");
    const bool turned = orientation >= 5;
    EXPECT_EQ(photo.full_size, (turned ? ImageSize{32, 48} : ImageSize{48, 32}));
    EXPECT_EQ(read_image_size(folder / "a.jpg"), photo.full_size);
    ASSERT_TRUE(photo.focal_hint);
    EXPECT_NEAR(*photo.focal_hint, 1.0, 1e-9);
    EXPECT_EQ(read_focal_hint(folder / "a.jpg"), photo.focal_hint);
    // Where the stored top left corner (red 0, green 0) and the stored top right (red 255) are to be seen.
    const int right = photo.image.width - 1;
    const int bottom = photo.image.height - 1;
    const std::array<std::array<int, 2>, 9> origin = {
        {{0, 0}, {0, 0}, {right, 0}, {right, bottom}, {0, bottom}, {0, 0}, {right, 0}, {right, bottom}, {0, bottom}}};
    const auto [x, y] = origin[static_cast<size_t>(orientation)];
    EXPECT_LT(photo.image.at(x, y).r + photo.image.at(x, y).g, 25) << orientation;
    const Rgb along = turned ? photo.image.at(x, bottom - y) : photo.image.at(right - x, y);
    EXPECT_GT(along.r, 230) << orientation;
    EXPECT_LT(along.g, 25) << orientation;
  }
}

TEST(Photo, ALargePhotoIsReadInTheSizeAskedFor) {
  const Folder folder;
  const RgbImage image = some_image(403, 302);
  write_file(folder / "a.jpg", encode_jpeg(image, 95));
  write_file(folder / "a.png", encode_png(image));
  const Photo jpeg = read_photo(folder / "a.jpg", 32000);
  EXPECT_EQ(jpeg.scale, 0.5);
  EXPECT_EQ(jpeg.image.width, 202);
  EXPECT_EQ(jpeg.full_size, (ImageSize{403, 302}));
  const Photo png = read_photo(folder / "a.png", 32000);
  EXPECT_EQ(png.scale, 0.5);
  EXPECT_EQ(png.image.width, 201);
  for (int x = 10; x < 190; x += 20) EXPECT_NEAR(jpeg.image.at(x, 60).r, png.image.at(x, 60).r, 4);
  EXPECT_EQ(png.image.at(7, 9).g, (image.at(14, 18).g + image.at(14, 19).g + 1) / 2);
  EXPECT_THAT(message_of([&] { read_photo(folder / "a.jpg", 100); }), HasSubstr("cannot be reduced to 100 pixels"));
}

TEST(Halved, EachPixelIsTheMeanOfFourWithoutAnOddLastRowOrColumn) {
  GreyImage image(5, 5);
  for (size_t i = 0; i < image.samples.size(); ++i) image.samples[i] = static_cast<uint8_t>(i * i % 251);
  const GreyImage half = halved(image);
  ASSERT_EQ(half.width, 2);
  ASSERT_EQ(half.height, 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) {
      const int sum = image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) + image.at(2 * x, 2 * y + 1) +
                      image.at(2 * x + 1, 2 * y + 1);
      EXPECT_EQ(half.at(x, y), (sum + 2) / 4) << x << " " << y;
    }
}

TEST(Pfm, KeepsEveryValueAndRefusesEarlyEnds) {
  Plane<float> values(5, 3);
  for (size_t i = 0; i < values.samples.size(); ++i) values.samples[i] = static_cast<float>(i) * 1.1f;
  values.samples[4] = std::numeric_limits<float>::infinity();
  const std::vector<uint8_t> bytes = encode_pfm(values);
  EXPECT_EQ(decode_pfm(bytes, "a"), values);
  for (size_t length = 0; length < bytes.size(); ++length)
    ASSERT_THROW(decode_pfm(std::span(bytes).first(length), "a"), std::runtime_error);
}

}  // namespace
}  // namespace ldp
