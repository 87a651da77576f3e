#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "core/panorama/file/coders/colour_packing.h"
#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/coders/range_coder.h"
#include "core/panorama/file/crc32c.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/golden/sealed_file.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp::file {
namespace {

using ::testing::HasSubstr;

constexpr LdpEncodeOptions kLossless{101, LdpCodec::none};

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const LdpError& e) {
    return e.what();
  }
  return "accepted";
}

void expect_same(const LayeredPanorama& a, const LayeredPanorama& b) {
  EXPECT_EQ(a.layers, b.layers);
  EXPECT_EQ(a.quality, b.quality);
  EXPECT_EQ(a.metadata, b.metadata);
  EXPECT_EQ(a.exposure, b.exposure);
  EXPECT_EQ(a.grid.width, b.grid.width);
  EXPECT_EQ(a.grid.rays, b.grid.rays);
  EXPECT_EQ(a.grid.wraps, b.grid.wraps);
  EXPECT_EQ(a.grid.arc.closed, b.grid.arc.closed);
  EXPECT_EQ(a.grid.arc.centre, b.grid.arc.centre);
  EXPECT_EQ(a.grid.arc.theta_end, b.grid.arc.theta_end);
  EXPECT_EQ(a.grid.theta_pitch, b.grid.theta_pitch);
  EXPECT_EQ(a.grid.v_top, b.grid.v_top);
  EXPECT_EQ(a.grid.w_near, b.grid.w_near);
  EXPECT_EQ(a.limits.outer_radius, b.limits.outer_radius);
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    EXPECT_EQ(a.cameras[i].name, b.cameras[i].name);
    EXPECT_EQ(a.cameras[i].intrinsics.k2, b.cameras[i].intrinsics.k2);
    EXPECT_EQ(a.cameras[i].pose.centre, b.cameras[i].pose.centre);
  }
}

TEST(Crc32c, KnownAnswers) {
  const std::string digits = "123456789";
  EXPECT_EQ(crc32c({reinterpret_cast<const uint8_t*>(digits.data()), digits.size()}), 0xE3069283U);
  EXPECT_EQ(crc32c(std::vector<uint8_t>(32, 0)), 0x8A9136AAU);
  EXPECT_EQ(crc32c(std::vector<uint8_t>(32, 0xFF)), 0x62A8AB43U);
  EXPECT_EQ(crc32c({}), 0U);
}

TEST(RangeCoder, GivesBackEveryDecisionAndUsesEveryByte) {
  std::mt19937 random(5);
  for (const uint32_t ones_in_1000 : {0U, 1U, 30U, 500U, 970U, 1000U}) {
    std::vector<bool> bits(20000);
    for (auto&& bit : bits) bit = random() % 1000 < ones_in_1000;
    std::array<BitModel, 3> models;
    RangeEncoder encoder;
    for (size_t i = 0; i < bits.size(); ++i) encoder.bit(models[i % 3], bits[i]);
    const std::vector<uint8_t> bytes = encoder.finish();
    models = {};
    RangeDecoder decoder(bytes);
    for (size_t i = 0; i < bits.size(); ++i) ASSERT_EQ(decoder.bit(models[i % 3]), bits[i]) << i;
    EXPECT_EQ(decoder.bytes_left(), 0u);
    EXPECT_FALSE(decoder.ended());
    const double p = ones_in_1000 / 1000.0;
    const double entropy = p > 0 && p < 1 ? -p * std::log2(p) - (1 - p) * std::log2(1 - p) : 0;
    EXPECT_LT(8.0 * static_cast<double>(bytes.size()), 20000 * (1.03 * entropy + 0.004) + 64);
  }
}

TEST(LdpFile, DecodingGivesBackWhatWasEncoded) {
  for (const int block_px : {0, 8, 16, 24, 5})
    for (const bool alpha : {false, true}) {
      SyntheticOptions options;
      options.block_px = block_px;
      options.alpha = alpha;
      options.rays = alpha ? Rays::central : Rays::pushbroom;
      options.wraps = options.local_exposure = alpha;
      options.width = 611 + block_px;
      const LayeredPanorama panorama = synthetic_panorama(options);
      const std::vector<uint8_t> file = encode_ldp(panorama, kLossless);
      expect_same(decode_ldp(file), panorama);
      EXPECT_THAT(verify_ldp(file), ::testing::IsEmpty());
    }
}

TEST(LdpFile, NoiseAndOddSizesSurvive) {
  std::mt19937 random(17);
  for (int round = 0; round < 60; ++round) {
    SyntheticOptions options;
    options.width = 1 + static_cast<int>(random() % 70);
    options.height = 1 + static_cast<int>(random() % 40);
    options.layers = 2;
    LayeredPanorama panorama = synthetic_panorama(options);
    for (Layer& layer : panorama.layers) {
      DisparityMap disparity(options.width, options.height, kNoDisparity);
      const auto present_in_10 = random() % 11;
      for (size_t i = 0; i < disparity.samples.size(); ++i) {
        layer.coverage.samples[i] = random() % 10 < present_in_10;
        layer.colour.samples[i] = {};
        if (layer.coverage.samples[i]) disparity.samples[i] = static_cast<uint16_t>(random() % (kDisparitySteps + 1));
      }
      layer.depth = encode_depth(disparity, static_cast<int>(random() % 20));
    }
    expect_same(decode_ldp(encode_ldp(panorama, kLossless)), panorama);
  }
}

TEST(LdpFile, ColourIsWebpUpToQuality96AndJpegAboveUnlessLossless) {
  const LayeredPanorama panorama = synthetic_panorama({});
  const auto codec = [&](int quality) {
    const std::vector<uint8_t> file = encode_ldp(panorama, {quality, LdpCodec::none});
    for (const LdpChunk& chunk : describe_ldp(file).chunks)
      if (chunk.type == "COLR" && chunk.layer == 0) return static_cast<int>(file[static_cast<size_t>(chunk.offset)]);
    return -1;
  };
  // Odd ones are JPEG, even ones WebP.
  for (const int quality : {50, 95, 96, 101}) EXPECT_EQ(codec(quality) % 2, 0) << quality;
  for (const int quality : {97, 100}) EXPECT_EQ(codec(quality) % 2, 1) << quality;
}

TEST(LdpFile, LossyColourIsCloseAndDepthStaysExact) {
  const LayeredPanorama panorama = synthetic_panorama({});
  for (const LdpCodec codec : {LdpCodec::jpeg, LdpCodec::webp}) {
    const LayeredPanorama back = decode_ldp(encode_ldp(panorama, {92, codec}));
    for (size_t l = 0; l < 3; ++l) {
      EXPECT_EQ(back.layers[l].depth, panorama.layers[l].depth);
      EXPECT_EQ(back.layers[l].coverage, panorama.layers[l].coverage);
      double sum = 0, count = 0;
      for (size_t i = 0; i < back.layers[l].colour.samples.size(); ++i) {
        if (!back.layers[l].coverage.samples[i]) {
          EXPECT_EQ(back.layers[l].colour.samples[i], (Rgb{0, 0, 0}));
          continue;
        }
        sum += std::pow(back.layers[l].colour.samples[i].g - panorama.layers[l].colour.samples[i].g, 2);
        ++count;
      }
      EXPECT_LT(std::sqrt(sum / count), l == 0 ? 4 : 6) << static_cast<int>(codec) << " layer " << l;
    }
  }
}

// A second layer of scattered pixels, as thin leaves leave behind them.
LayeredPanorama scattered_panorama() {
  LayeredPanorama panorama = synthetic_panorama({300, 100, 16, 2, false, Rays::pushbroom, false});
  std::mt19937 random(3);
  Layer& layer = panorama.layers[1];
  DisparityMap disparity(300, 100, kNoDisparity);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 300; ++x) {
      const bool present = x < 120 && (x < 48 || random() % 4 == 0);
      layer.coverage.at(x, y) = present;
      const auto light = static_cast<uint8_t>(60 + random() % 120);
      layer.colour.at(x, y) = present ? Rgb{light, static_cast<uint8_t>(light + 40), light} : Rgb{};
      if (present) disparity.at(x, y) = static_cast<uint16_t>(500 + 3 * x);
    }
  layer.depth = encode_depth(disparity, 16);
  return panorama;
}

double colour_error(const Layer& a, const Layer& b) {
  double sum = 0;
  for (size_t i = 0; i < a.colour.samples.size(); ++i) {
    const Rgb p = a.colour.samples[i], q = b.colour.samples[i];
    sum += std::pow(p.r - q.r, 2) + std::pow(p.g - q.g, 2) + std::pow(p.b - q.b, 2);
  }
  return sum;
}

double colour_bytes(const std::vector<uint8_t>& file, int layer) {
  for (const LdpChunk& chunk : describe_ldp(file).chunks)
    if (chunk.type == "COLR" && chunk.layer == layer) return static_cast<double>(chunk.length);
  return 0;
}

TEST(LdpFile, LossyColourBehindTheFrontTakesLessRoom) {
  LayeredPanorama panorama = synthetic_panorama({300, 100, 16, 1, false, Rays::pushbroom, false});
  panorama.layers.push_back(panorama.layers[0]);
  for (const LdpCodec codec : {LdpCodec::jpeg, LdpCodec::webp}) {
    const std::vector<uint8_t> lossy = encode_ldp(panorama, {90, codec}), coarse = encode_ldp(panorama, {10, codec});
    EXPECT_LT(colour_bytes(lossy, 1), 0.8 * colour_bytes(lossy, 0));
    EXPECT_LE(colour_bytes(coarse, 1), colour_bytes(coarse, 0)) << "and there is a least quality";
  }
  const std::vector<uint8_t> exact = encode_ldp(panorama, kLossless);
  EXPECT_EQ(colour_bytes(exact, 1), colour_bytes(exact, 0));
}

TEST(GatheredColours, TheCurveGoesThroughEveryPixelStepByStep) {
  std::vector<int> seen(kTilePixels);
  for (size_t i = 0; i < kTileCurve.size(); ++i) {
    ++seen[static_cast<size_t>(kTileCurve[i].y * kTile + kTileCurve[i].x)];
    if (i == 0) continue;
    EXPECT_EQ(std::abs(kTileCurve[i].x - kTileCurve[i - 1].x) + std::abs(kTileCurve[i].y - kTileCurve[i - 1].y), 1);
  }
  EXPECT_THAT(seen, ::testing::Each(1));
}

TEST(GatheredColours, ScatteredPixelsTakeLessRoomAndAreAsExact) {
  const LayeredPanorama panorama = scattered_panorama();
  const std::vector<uint8_t> file = encode_ldp(panorama, {90, LdpCodec::none});
  const std::vector<uint8_t> plain = encode_ldp(panorama, {90, LdpCodec::webp});
  EXPECT_EQ(describe_ldp(file).version, 2);
  EXPECT_EQ(describe_ldp(plain).version, 1);
  EXPECT_LT(colour_bytes(file, 1), 0.95 * colour_bytes(plain, 1));
  EXPECT_EQ(colour_bytes(file, 0), colour_bytes(plain, 0)) << "a dense layer stays as it is";
  EXPECT_LE(colour_error(decode_ldp(file).layers[1], panorama.layers[1]),
            17.0 / 16 * colour_error(decode_ldp(plain).layers[1], panorama.layers[1]));
}

TEST(GatheredColours, LosslessOnesComeBackExactly) {
  const LayeredPanorama panorama = scattered_panorama();
  const std::vector<uint8_t> file = encode_ldp(panorama, kLossless);
  EXPECT_EQ(describe_ldp(file).version, 2);
  expect_same(decode_ldp(file), panorama);
  EXPECT_THAT(verify_ldp(file), ::testing::IsEmpty());
}

TEST(GatheredColours, AreRefusedInAFileOfVersion1) {
  std::vector<uint8_t> file = encode_ldp(scattered_panorama(), {90, LdpCodec::none});
  file[8] = 1;
  seal(file);
  EXPECT_THAT(refusal([&] { decode_ldp(file); }), HasSubstr("chunk COLR of layer 2, strip 1"));
  EXPECT_THAT(refusal([&] { decode_ldp(file); }), HasSubstr("codec: expected 0 to 2, found 3"));
}

TEST(LdpFile, BytesDoNotDependOnThreads) {
  SyntheticOptions options;
  options.width = 1500;
  options.block_px = 16;
  const LayeredPanorama panorama = synthetic_panorama(options);
  Job four;
  four.threads = 4;
  EXPECT_EQ(encode_ldp(panorama, {}, four), encode_ldp(panorama, {}));
  EXPECT_EQ(decode_ldp(encode_ldp(panorama, {}), {}, four).layers, decode_ldp(encode_ldp(panorama, {})).layers);
}

TEST(LdpReader, PartsEqualTheWhole) {
  SyntheticOptions options;
  options.width = 1400;
  options.block_px = 12;
  options.alpha = true;
  const LayeredPanorama panorama = synthetic_panorama(options);
  const std::vector<uint8_t> file = encode_ldp(panorama, kLossless);
  const LdpReader reader(file);
  for (const LdpColumns columns : {LdpColumns{0, 1}, LdpColumns{480, 540}, LdpColumns{516, 1400}}) {
    const Layer part = reader.read_layer(1, columns, true);
    const Layer& whole = panorama.layers[1];
    for (int y = 0; y < options.height; ++y)
      for (int x = columns.begin; x < columns.end; ++x) {
        const int px = x - columns.begin;
        ASSERT_EQ(part.coverage.at(px, y), whole.coverage.at(x, y));
        ASSERT_EQ(part.depth.disparity(px, y), whole.depth.disparity(x, y));
        ASSERT_EQ(part.alpha.at(px, y), whole.alpha.at(x, y));
        ASSERT_EQ(part.colour.at(px, y), whole.colour.at(x, y));
      }
  }
  EXPECT_TRUE(reader.read_layer(0, {0, 120}, false).colour.empty());
  EXPECT_THROW(reader.read_layer(0, {5, 120}, false), std::logic_error);
  EXPECT_THROW(reader.read_layer(3), std::logic_error);
}

TEST(LdpReader, DamageInOneStripLeavesTheOthersReadable) {
  SyntheticOptions options;
  options.width = 1100;
  std::vector<uint8_t> file = encode_ldp(synthetic_panorama(options), kLossless);
  for (const LdpChunk& chunk : describe_ldp(file).chunks)
    if (chunk.type == "DPTH" && chunk.layer == 0 && chunk.strip == 1)
      file[static_cast<size_t>(chunk.offset + chunk.length / 2)] ^= 1;
  const LdpReader reader(file);
  EXPECT_NO_THROW(reader.read_layer(0, {0, 512}, true));
  EXPECT_NO_THROW(reader.read_layer(1));
  EXPECT_THAT(refusal([&] { reader.read_layer(0); }), HasSubstr("chunk DPTH of layer 1, strip 2 at offset "));
}

TEST(LdpDescription, TellsWhatIsThereWithoutDecoding) {
  SyntheticOptions options;
  options.block_px = 8;
  const LayeredPanorama panorama = synthetic_panorama(options);
  const std::vector<uint8_t> file = encode_ldp(panorama, {90, LdpCodec::webp});
  const LdpDescription description = describe_ldp(file);
  EXPECT_EQ(description.version, 1) << "a file without gathered colours stays readable for the first readers";
  EXPECT_EQ(description.file_bytes, file.size());
  ASSERT_EQ(description.layers.size(), 3u);
  EXPECT_EQ(description.layers[0].present_pixels, 200u * 90u);
  EXPECT_EQ(description.layers[1].block_px, 8);
  EXPECT_EQ(description.panorama.cameras.size(), 3u);
  EXPECT_EQ(description.thumbnail[0], 0xFF);
  uint64_t sum = 32 + 32 * description.chunks.size();
  for (const LdpChunk& chunk : description.chunks) sum += chunk.length;
  EXPECT_EQ(sum, file.size());
}

// 960 columns make squares of two pixels.
TEST(LdpDescription, TheThumbnailShowsWhatIsSeenFirstAndNoHoles) {
  LayeredPanorama panorama = synthetic_panorama({960, 90, 8, 2});
  const auto fill = [](Layer& layer, int columns, uint16_t disparity, Rgb colour) {
    DisparityMap depth(960, 90, kNoDisparity);
    layer.colour = RgbImage(960, 90);
    layer.coverage = Plane<uint8_t>(960, 90);
    for (int y = 0; y < 90; ++y)
      for (int x = 0; x < columns; ++x)
        depth.at(x, y) = disparity, layer.colour.at(x, y) = colour, layer.coverage.at(x, y) = 1;
    layer.depth = encode_depth(depth, 8);
  };
  fill(panorama.layers[0], 300, 3000, {200, 100, 50});
  fill(panorama.layers[1], 600, 500, {50, 200, 100});
  const RgbImage small = decode_image(describe_ldp(encode_ldp(panorama, {90, LdpCodec::webp})).thumbnail, "thumbnail");
  ASSERT_EQ(small.width, 480);
  ASSERT_EQ(small.height, 45);
  EXPECT_NEAR(small.at(75, 20).r, 200, 6);
  EXPECT_NEAR(small.at(225, 20).g, 200, 6);
  for (const int x : {305, 400, 475}) {
    EXPECT_NEAR(small.at(x, 20).r, 50, 12) << x;
    EXPECT_NEAR(small.at(x, 20).g, 200, 12) << x;
  }
}

TEST(LdpDescription, TellsHowColoursAreCoded) {
  LayeredPanorama panorama = synthetic_panorama({});
  Layer nothing = panorama.layers[0];
  std::fill(nothing.coverage.samples.begin(), nothing.coverage.samples.end(), uint8_t{0});
  std::fill(nothing.depth.codes.samples.begin(), nothing.depth.codes.samples.end(), uint8_t{0});
  std::fill(nothing.colour.samples.begin(), nothing.colour.samples.end(), Rgb{});
  panorama.layers = {panorama.layers[0], nothing};
  const auto codings = [&](int quality, int layer) {
    const std::vector<uint8_t> file = encode_ldp(panorama, {quality, LdpCodec::none});
    return LdpReader(file).colour_codings(layer);
  };
  using testing::ElementsAre;
  EXPECT_THAT(codings(90, 0), ElementsAre(ColourCoding::webp));
  EXPECT_THAT(codings(100, 0), ElementsAre(ColourCoding::jpeg));
  EXPECT_THAT(codings(101, 0), ElementsAre(ColourCoding::webp_lossless));
  EXPECT_THAT(codings(90, 1), testing::IsEmpty());
}

TEST(LdpErrors, EveryTruncationIsRefused) {
  const std::vector<uint8_t> file = encode_ldp(synthetic_panorama({64, 48}), {});
  for (size_t length = 0; length < file.size(); ++length)
    ASSERT_NE(refusal([&] { decode_ldp(std::span(file).first(length)); }), "accepted") << length;
}

TEST(LdpErrors, EveryByteThatIsFlippedIsNoticed) {
  std::mt19937 random(23);
  const std::vector<uint8_t> file = encode_ldp(synthetic_panorama({64, 48}), {});
  for (size_t i = 0; i < file.size(); ++i) {
    std::vector<uint8_t> damaged = file;
    damaged[i] ^= static_cast<uint8_t>(1 + random() % 255);
    ASSERT_NE(refusal([&] { decode_ldp(damaged); }), "accepted") << i;
    ASSERT_FALSE(verify_ldp(damaged).empty());
  }
}

TEST(LdpErrors, DamageBehindRightChecksumsIsRefusedOrDecodesToSomethingLawful) {
  std::mt19937 random(29);
  SyntheticOptions options{64, 48};
  options.block_px = 8;
  options.alpha = true;
  const std::vector<uint8_t> file = encode_ldp(synthetic_panorama(options), {});
  const auto head_end = static_cast<size_t>(describe_ldp(file).chunks[0].offset + 8);
  int decoded = 0;
  for (int i = 0; i < 4000; ++i) {
    std::vector<uint8_t> damaged = file;
    for (auto flips = 1 + random() % 3; flips > 0; --flips)
      damaged[head_end + random() % (file.size() - head_end)] ^= static_cast<uint8_t>(1 + random() % 255);
    seal(damaged);
    decoded += refusal([&] { decode_ldp(damaged, {1 << 16}); }) == "accepted";
  }
  EXPECT_GT(decoded, 0) << "the test never got past the first checks";
}

TEST(LdpErrors, AreClearWords) {
  const std::vector<uint8_t> file = encode_ldp(synthetic_panorama({64, 48}), {});
  const auto with = [&](size_t at, std::vector<uint8_t> bytes, bool sealed) {
    std::vector<uint8_t> damaged = file;
    std::copy(bytes.begin(), bytes.end(), damaged.begin() + static_cast<std::ptrdiff_t>(at));
    if (sealed) seal(damaged);
    return refusal([&] { decode_ldp(damaged); });
  };
  EXPECT_EQ(with(0, {'P'}, false), "header at offset 0: not an .ldp file");
  EXPECT_EQ(with(4, {'\n'}, false),
            "header at offset 0: the file was changed on its way: it must be transferred as binary, not as text");
  EXPECT_EQ(with(8, {3}, true), "header at offset 0: version: expected 1 to 2, found 3 (a newer program may read it)");
  const auto head = static_cast<size_t>(describe_ldp(file).chunks[0].offset);
  const std::string where = "chunk HEAD at offset " + std::to_string(head);
  EXPECT_EQ(with(head, {0xFF, 0xFF, 0, 0, 0xFF, 0x3F, 0, 0}, true),
            where + ": height: expected 1 to 16368, found 16383");
  EXPECT_EQ(with(head, {0xFF, 0xFF, 0, 0, 0xF0, 0x3F, 0, 0}, true),
            where + ": width x height: expected at most 268435456, found 1072676880");
  EXPECT_THAT(with(head, {0, 0, 0, 0x80, 1, 0, 0, 0}, true),
              HasSubstr(where + ": width: expected 1 to 65535, found 2147483648"));
  EXPECT_THAT(with(head + 9, {7}, true), HasSubstr(where + ": kind of rays: expected 0 to 1, found 7"));
  EXPECT_THAT(with(head + 40, {1}, false), HasSubstr(where + ": checksum: expected 0x"));
  EXPECT_THAT(with(32, {'H', 'E', 'A', 'T'}, true), HasSubstr("chunk HEAT at offset"));
  EXPECT_THAT(refusal([&] { decode_ldp(file, {1000}); }),
              HasSubstr("width x height: expected at most 1000, found 3072"));
}

TEST(LdpErrors, OfLocalExposureAreClearWords) {
  SyntheticOptions options{64, 48};
  options.local_exposure = true;
  const std::vector<uint8_t> file = encode_ldp(synthetic_panorama(options), {});
  size_t at = 0;
  for (const LdpChunk& chunk : describe_ldp(file).chunks)
    if (chunk.type == "expo") at = static_cast<size_t>(chunk.offset);
  const auto with = [&](size_t offset, std::vector<uint8_t> bytes) {
    std::vector<uint8_t> damaged = file;
    std::copy(bytes.begin(), bytes.end(), damaged.begin() + static_cast<std::ptrdiff_t>(at + offset));
    seal(damaged);
    return refusal([&] { decode_ldp(damaged); });
  };
  const std::string where = "chunk expo at offset " + std::to_string(at) + ": ";
  EXPECT_EQ(with(0, {0, 0, 0, 0}), where + "the response: expected rising light, found 0");
  EXPECT_EQ(with(4, {5, 0, 0, 0}), where + "the response: expected rising light, found 5");
  EXPECT_EQ(with(64, {1, 1, 0, 0}), where + "columns of the exposure: expected 1 to 256, found 257");
  EXPECT_EQ(with(68, {0, 0, 0, 0}), where + "rows of the exposure: expected 1 to 256, found 0");
  EXPECT_THAT(with(68, {2, 0, 0, 0}), HasSubstr(where + "its length: expected"));
  EXPECT_EQ(with(74, {0, 0}), where + "a factor of the exposure: expected 1 to 65535, found 0");
}

TEST(LdpErrors, MorePixelsThanItsBytesCanHoldAreRefusedUndecoded) {
  std::vector<uint8_t> file = encode_ldp(synthetic_panorama({64, 48}), {});
  const auto head = static_cast<std::ptrdiff_t>(describe_ldp(file).chunks[0].offset);
  const std::vector<uint8_t> size = {0, 64, 0, 0, 0, 32, 0, 0, 8};  // 16384 x 8192 in 8 layers
  std::copy(size.begin(), size.end(), file.begin() + head);
  seal(file);
  const std::string bytes = std::to_string(file.size());
  const std::string expected =
      "chunk HEAD at offset " + std::to_string(head) + ": width x height x layers: expected at most " +
      std::to_string((1 << 26) + 256 * file.size()) + " in " + bytes + " bytes, found 1073741824";
  EXPECT_EQ(refusal([&] { describe_ldp(file); }), expected);
  EXPECT_EQ(verify_ldp(file), std::vector<std::string>{expected});
}

TEST(LdpErrors, AStreamOfDepthsThatEndsIsDecodedNoFurther) {
  DepthStrip strip;
  strip.block_px = 8;
  strip.tiles = {4, 64};
  strip.coverage = {64, 1024, 7};
  strip.codes = {64, 1024};
  strip.ranges = {8, 128};
  const std::vector<uint8_t> bytes(8, 0xFF);
  EXPECT_THAT(refusal([&] {
                decode_depth_strip(bytes, {"chunk", 0}, strip);
              }),
              HasSubstr("its coded data: expected an end within its 8 bytes, found none"));
  EXPECT_EQ(strip.coverage.at(0, 1023), 7);
}

TEST(LdpErrors, UnknownChunksAreSkippedUnlessTheyAreNeeded) {
  std::vector<uint8_t> file = encode_ldp(synthetic_panorama({64, 48}), {});
  const LdpDescription description = describe_ldp(file);
  for (size_t i = 0; i < description.chunks.size(); ++i) {
    if (description.chunks[i].type != "qual") continue;
    file[32 + 32 * i] = 'x';
    seal(file);
    EXPECT_EQ(refusal([&] { decode_ldp(file); }), "accepted");
    EXPECT_TRUE(decode_ldp(file).quality.empty());
    file[32 + 32 * i] = 'X';
    seal(file);
    EXPECT_THAT(refusal([&] { decode_ldp(file); }), HasSubstr("needed to read the file, but unknown"));
  }
}

TEST(LdpEncoder, RefusesWhatItCouldNotGiveBack) {
  const LayeredPanorama sound = synthetic_panorama({64, 48});
  const auto refuses = [&](const std::function<void(LayeredPanorama&)>& spoil) {
    LayeredPanorama panorama = sound;
    spoil(panorama);
    EXPECT_THROW(encode_ldp(panorama, {}), std::logic_error);
  };
  refuses([](LayeredPanorama& p) { p.layers.clear(); });
  refuses([](LayeredPanorama& p) { p.layers[0].coverage.at(3, 3) = 2; });
  refuses([](LayeredPanorama& p) { p.layers[0].depth.codes.at(3, 3) = 16; });
  refuses([](LayeredPanorama& p) { p.layers[1].coverage.samples.assign(p.layers[1].coverage.samples.size(), 0); });
  refuses([](LayeredPanorama& p) { p.layers[0].depth.ranges.samples[0] = {9, 3}; });
  refuses([](LayeredPanorama& p) { p.layers[0].colour = RgbImage(3, 3); });
  EXPECT_THROW(encode_ldp(sound, {0, LdpCodec::none}), std::logic_error);
  EXPECT_THROW(encode_ldp(sound, {101, LdpCodec::jpeg}), std::logic_error);
  LayeredPanorama broken = sound;
  broken.grid.v_pitch = std::nan("");
  EXPECT_THROW(encode_ldp(broken, {}), std::runtime_error);
}

TEST(LdpEncoder, WritesNamesThatAreNoUtf8AsUtf8) {
  LayeredPanorama panorama = synthetic_panorama({});
  panorama.cameras.at(0).name = "caf\xe9.jpg";
  panorama.metadata["device"] = "\xff";
  const LayeredPanorama decoded = decode_ldp(encode_ldp(panorama, {}));
  EXPECT_EQ(decoded.cameras.at(0).name, "caf\uFFFD.jpg");
  EXPECT_EQ(decoded.metadata.at("device"), "\uFFFD");
}

TEST(LdpEncoder, StopsWhenTheJobIsStopped) {
  std::stop_source source;
  source.request_stop();
  Job job;
  job.stop = source.get_token();
  EXPECT_THROW(encode_ldp(synthetic_panorama({}), {}, job), Cancelled);
}

}  // namespace
}  // namespace ldp::file
