// The coders of the file's strips, each alone: what goes in comes out, whatever its size, shape and blocks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "core/panorama/file/bytes.h"
#include "core/panorama/file/coders/alpha_coding.h"
#include "core/panorama/file/coders/colour_coding.h"
#include "core/panorama/file/coders/colour_packing.h"
#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/coders/guided_colour.h"
#include "core/panorama/file/coders/range_coder.h"
#include "core/photos/images.h"
#include "tests/unit/rms.h"

namespace ldp::file {
namespace {

using test::rms;
using testing::AllOf;
using testing::HasSubstr;

std::string refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const LdpError& error) {
    return error.what();
  }
  return "";
}

const Place kPlace("chunk TEST", 100);

// --- bytes -----------------------------------------------------------------------------------------------------------

TEST(Bytes, NumbersAreLittleEndianAndComeBack) {
  ByteWriter writer;
  writer.u8(0xFE);
  writer.u16(0x1234);
  writer.u32(0xDEADBEEF);
  writer.u64(0x0123456789ABCDEF);
  writer.f64(-0.1);
  writer.append(std::string_view("end"));
  EXPECT_EQ(writer.bytes[1], 0x34);
  EXPECT_EQ(writer.bytes[3], 0xEF);
  EXPECT_EQ(writer.bytes[7], 0xEF);
  ByteReader reader(writer.bytes, kPlace);
  EXPECT_EQ(reader.u8(), 0xFE);
  EXPECT_EQ(reader.u16(), 0x1234);
  EXPECT_EQ(reader.u32(), 0xDEADBEEF);
  EXPECT_EQ(reader.u64(), 0x0123456789ABCDEF);
  EXPECT_EQ(reader.finite("x"), -0.1);
  EXPECT_EQ(reader.left(), 3U);
  EXPECT_EQ(reader.text(3), "end");
  reader.expect_end();
}

TEST(Bytes, WhatIsMissingOutOfBoundsOrTooMuchIsNamedWithItsPlace) {
  const std::vector<uint8_t> bytes{7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x7F};  // 7, then infinity
  const auto at = [&](size_t skipped) {
    ByteReader reader(bytes, kPlace);
    reader.take(skipped);
    return reader;
  };
  EXPECT_THAT(refusal([&] { at(9).u32(); }), AllOf(HasSubstr("chunk TEST at offset 100"),
                                                   HasSubstr("its length: expected at least 13 bytes, found 12")));
  EXPECT_EQ(refusal([&] { at(8).u32(); }), "");
  EXPECT_THAT(refusal([&] { at(0).whole("width", 8, 9); }), HasSubstr("width: expected 8 to 9, found 7"));
  EXPECT_THAT(refusal([&] { at(0).whole("width", 0, 6); }), HasSubstr("width: expected 0 to 6, found 7"));
  EXPECT_EQ(at(0).whole("width", 7, 7), 7);
  EXPECT_THAT(refusal([&] { at(0).choice("codec", 6); }), HasSubstr("codec: expected 0 to 6, found 7"));
  EXPECT_EQ(at(0).choice("codec", 7), 7);
  EXPECT_THAT(refusal([&] { at(4).finite("theta"); }), HasSubstr("theta: expected a finite number"));
  EXPECT_THAT(refusal([&] { at(10).expect_end(); }), HasSubstr("its length: expected 10 bytes, found 12"));
  EXPECT_THAT(refusal([&] { at(4).take(SIZE_MAX); }), HasSubstr("its length"));
}

// --- decisions -------------------------------------------------------------------------------------------------------

TEST(BitModel, IsTheMeanOfWhatItSawAndNeverSure) {
  BitModel model;
  for (int i = 0; i < 30; ++i) model.update(i % 3 == 0);
  EXPECT_NEAR(model.zero / 65536.0, 2.0 / 3, 0.05);
  for (int i = 0; i < 100'000; ++i) model.update(false);
  EXPECT_LT(model.zero, 65536);
  EXPECT_GT(model.zero, 60'000);
  for (int i = 0; i < 100'000; ++i) model.update(true);
  EXPECT_GT(model.zero, 0);
  EXPECT_LT(model.zero, 5'000);
  EXPECT_EQ(model.seen, BitModel::kMostSeen);
}

TEST(RangeCoding, RareDecisionsTakeAsManyBytesAsTheyTell) {
  for (const double share : {0.5, 0.1, 0.01}) {
    std::mt19937 random(5);
    std::vector<bool> bits;
    for (int i = 0; i < 40'000; ++i) bits.push_back(static_cast<double>(random() % 10'000) < share * 10'000);
    RangeEncoder encoder;
    BitModel model;
    for (const bool bit : bits) encoder.bit(model, bit);
    const std::vector<uint8_t> bytes = encoder.finish();
    const double entropy = -share * std::log2(share) - (1 - share) * std::log2(1 - share);
    const double told = 8.0 * static_cast<double>(bytes.size()) / static_cast<double>(bits.size());
    EXPECT_GT(told, 0.93 * entropy);
    EXPECT_LT(told, 1.1 * entropy + 0.01);
    RangeDecoder decoder(bytes);
    BitModel again;
    for (size_t i = 0; i < bits.size(); ++i) ASSERT_EQ(decoder.bit(again), bits[i]) << i;
    EXPECT_FALSE(decoder.ended());
    EXPECT_LE(decoder.bytes_left(), 4U);
  }
}

TEST(RangeCoding, CarriesRunThroughBytesOfOnes) {
  // Certain models let `low` creep up to the next carry for a long time.
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::vector<bool> bits;
    for (int i = 0; i < 300; ++i) bits.push_back(random() % 64 != 0 || i % 50 == 49);
    RangeEncoder encoder;
    BitModel sure{60'000, BitModel::kMostSeen};
    for (const bool bit : bits) {
      BitModel model = sure;
      encoder.bit(model, bit);
    }
    const std::vector<uint8_t> bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    for (size_t i = 0; i < bits.size(); ++i) {
      BitModel model = sure;
      ASSERT_EQ(decoder.bit(model), bits[i]) << "seed " << seed << ", " << i;
    }
  }
}

TEST(RangeCoding, AStreamThatEndsEarlyIsToldOf) {
  RangeEncoder encoder;
  BitModel model;
  for (int i = 0; i < 4000; ++i) encoder.bit(model, static_cast<uint32_t>(i) * 2654435761U >> 31 != 0);
  std::vector<uint8_t> bytes = encoder.finish();
  bytes.resize(bytes.size() / 2);
  RangeDecoder decoder(bytes);
  BitModel again;
  for (int i = 0; i < 4000; ++i) decoder.bit(again);
  EXPECT_TRUE(decoder.ended());
  EXPECT_EQ(decoder.bytes_left(), 0U);
}

// --- depth -----------------------------------------------------------------------------------------------------------

// Of random blobs, with ranges of every width and codes that are often their neighbours'.
DepthStrip random_strip(int width, int height, int block_px, int density, unsigned seed) {
  std::mt19937 random(seed);
  DepthStrip strip;
  strip.block_px = block_px;
  strip.coverage = Plane<uint8_t>(width, height);
  strip.codes = Plane<uint8_t>(width, height);
  const int across = block_px == 0 ? 1 : (width + block_px - 1) / block_px,
            down = block_px == 0 ? 1 : (height + block_px - 1) / block_px;
  strip.ranges = Plane<BlockRange>(across, down);
  for (int by = 0; by < height; by += 5)
    for (int bx = 0; bx < width; bx += 7) {
      const bool present = static_cast<int>(random() % 8) < density;
      for (int y = by; y < std::min(height, by + 5); ++y)
        for (int x = bx; x < std::min(width, bx + 7); ++x) strip.coverage.at(x, y) = present ? 1 : 0;
    }
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < across; ++x) {
      const auto low = static_cast<uint8_t>(random() % 200);
      const auto span = static_cast<uint8_t>(random() % 3 == 0 ? 0 : random() % 56);
      strip.ranges.at(x, y) = {low, static_cast<uint8_t>(low + span)};
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const BlockRange range = block_px == 0 ? strip.ranges.samples[0] : strip.ranges.at(x / block_px, y / block_px);
      const bool as_before = x > 0 && random() % 4 != 0;
      const auto code = static_cast<uint8_t>(as_before ? strip.codes.at(x - 1, y) : random() % 16);
      if (strip.coverage.at(x, y) && range.low < range.high) strip.codes.at(x, y) = code;
    }
  strip.tiles = tile_states(strip.coverage);
  return strip;
}

DepthStrip frame_of(const DepthStrip& strip) {
  DepthStrip empty;
  empty.block_px = strip.block_px;
  empty.ranges =
      strip.block_px == 0 ? strip.ranges : Plane<BlockRange>(strip.ranges.width, strip.ranges.height, {0, 0});
  empty.tiles = Plane<TileState>(strip.tiles.width, strip.tiles.height);
  empty.coverage = Plane<uint8_t>(strip.coverage.width, strip.coverage.height);
  empty.codes = Plane<uint8_t>(strip.codes.width, strip.codes.height);
  return empty;
}

bool any_in_block(const DepthStrip& strip, int bx, int by) {
  for (int y = by * strip.block_px; y < std::min(strip.coverage.height, (by + 1) * strip.block_px); ++y)
    for (int x = bx * strip.block_px; x < std::min(strip.coverage.width, (bx + 1) * strip.block_px); ++x)
      if (strip.coverage.at(x, y)) return true;
  return false;
}

class DepthStrips : public testing::TestWithParam<int> {};

TEST_P(DepthStrips, OfEverySizeAndDensityComeBack) {
  const int block_px = GetParam();
  unsigned seed = 0;
  for (const int width : {1, 2, 15, 16, 17, 33, 64})
    for (const int height : {1, 3, 16, 31})
      for (const int density : {0, 1, 6, 8}) {
        const DepthStrip strip = random_strip(width, height, block_px, density, ++seed);
        const std::vector<uint8_t> bytes = encode_depth_strip(strip);
        DepthStrip decoded = frame_of(strip);
        decode_depth_strip(bytes, kPlace, decoded);
        ASSERT_EQ(decoded.coverage, strip.coverage) << width << "x" << height << ", " << density;
        ASSERT_EQ(decoded.codes, strip.codes) << width << "x" << height << ", " << density;
        for (int by = 0; block_px > 0 && by < strip.ranges.height; ++by)
          for (int bx = 0; bx < strip.ranges.width; ++bx) {
            if (!any_in_block(strip, bx, by)) continue;
            ASSERT_EQ(decoded.ranges.at(bx, by), strip.ranges.at(bx, by));
          }
      }
}

TEST_P(DepthStrips, CutShortOrLengthenedAreRefused) {
  const DepthStrip strip = random_strip(64, 48, GetParam(), 6, 9);
  const std::vector<uint8_t> bytes = encode_depth_strip(strip);
  for (size_t kept = 0; kept + 5 < bytes.size(); kept += 1 + bytes.size() / 40) {
    DepthStrip decoded = frame_of(strip);
    EXPECT_NE(refusal([&] { decode_depth_strip(std::span(bytes).first(kept), kPlace, decoded); }), "") << kept;
  }
  std::vector<uint8_t> longer = bytes;
  longer.insert(longer.end(), 6, 0);
  DepthStrip decoded = frame_of(strip);
  EXPECT_THAT(refusal([&] { decode_depth_strip(longer, kPlace, decoded); }), HasSubstr("more than were used"));
}

TEST_P(DepthStrips, DamagedOnesAreRefusedOrLawful) {
  const DepthStrip strip = random_strip(48, 40, GetParam(), 6, 10);
  const std::vector<uint8_t> bytes = encode_depth_strip(strip);
  std::mt19937 random(11);
  for (int i = 0; i < 300; ++i) {
    std::vector<uint8_t> damaged = bytes;
    for (int k = 0; k < 1 + i % 4; ++k) damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
    DepthStrip decoded = frame_of(strip);
    refusal([&] { decode_depth_strip(damaged, kPlace, decoded); });
    for (const uint8_t code : decoded.codes.samples) ASSERT_LT(code, 16);
    for (const uint8_t present : decoded.coverage.samples) ASSERT_LE(present, 1);
    for (const BlockRange& range : decoded.ranges.samples) ASSERT_LE(range.low, range.high);
  }
}

INSTANTIATE_TEST_SUITE_P(OfBlocks, DepthStrips, testing::Values(0, 1, 5, 16, 64));

TEST(TileStates, AreWhatTheirPixelsAre) {
  Plane<uint8_t> coverage(40, 20, 1);
  for (int y = 0; y < 16; ++y)
    for (int x = 16; x < 32; ++x) coverage.at(x, y) = 0;
  coverage.at(39, 19) = 0;
  const Plane<TileState> tiles = tile_states(coverage);
  EXPECT_EQ(tiles.width, 3);
  EXPECT_EQ(tiles.height, 2);
  EXPECT_EQ(tiles.at(0, 0), TileState::full);
  EXPECT_EQ(tiles.at(2, 1), TileState::mixed);
  EXPECT_EQ(tiles.at(1, 0), TileState::mixed) << "where few are empty, a tile more is cheaper than a third state";
  const Plane<TileState> sparse = tile_states(Plane<uint8_t>(64, 64, 0));
  EXPECT_TRUE(std::all_of(sparse.samples.begin(), sparse.samples.end(), [](auto t) { return t == TileState::empty; }));
}

// --- colours ---------------------------------------------------------------------------------------------------------

TEST(ColourPackings, GiveEveryPixelAPlaceOfItsOwn) {
  unsigned seed = 20;
  for (const ColourLayout layout : {ColourLayout::plain, ColourLayout::gathered})
    for (const int width : {1, 16, 17, 50})
      for (const int density : {0, 2, 7, 8}) {
        const DepthStrip strip = random_strip(width, 37, 16, density, ++seed);
        const ColourPacking packing(strip, layout);
        const ImageSize size = packing.size();
        std::set<std::pair<int, int>> places, pixels;
        packing.for_each_pixel([&](int x, int y, int px, int py) {
          EXPECT_TRUE(strip.coverage.at(x, y));
          EXPECT_TRUE(px >= 0 && py >= 0 && px < size.width && py < size.height) << px << ", " << py;
          places.emplace(px, py);
          pixels.emplace(x, y);
        });
        const auto present =
            static_cast<size_t>(std::count(strip.coverage.samples.begin(), strip.coverage.samples.end(), uint8_t{1}));
        EXPECT_EQ(places.size(), present);
        EXPECT_EQ(pixels.size(), present);
        EXPECT_TRUE(layout == ColourLayout::gathered || packing.gathered_pixels() == 0);
      }
}

TEST(ColourStrips, LosslessOnesComeBackAndAbsentPixelsAreBlack) {
  std::mt19937 random(30);
  for (const int density : {1, 4, 8}) {
    const DepthStrip strip = random_strip(45, 33, 16, density, static_cast<unsigned>(density));
    RgbImage colour(45, 33);
    for (Rgb& c : colour.samples)
      c = {static_cast<uint8_t>(random()), static_cast<uint8_t>(random()), static_cast<uint8_t>(random())};
    const std::vector<uint8_t> bytes = encode_colour_strip(strip, colour, {101, LdpCodec::none});
    const RgbImage decoded = decode_colour_strip(bytes, kPlace, strip, kLdpVersion);
    for (size_t i = 0; i < colour.samples.size(); ++i)
      ASSERT_EQ(decoded.samples[i], strip.coverage.samples[i] ? colour.samples[i] : (Rgb{0, 0, 0})) << i;
    for (size_t kept = 0; kept < bytes.size(); kept += 1 + bytes.size() / 20)
      EXPECT_NE(refusal([&] { decode_colour_strip(std::span(bytes).first(kept), kPlace, strip, kLdpVersion); }), "");
  }
}

TEST(AlphaStrips, ComeBackAtEverySizeAndAbsentPixelsAreZero) {
  std::mt19937 random(40);
  for (const int width : {1, 7, 16, 65})
    for (const int density : {0, 3, 8}) {
      const Plane<uint8_t> coverage = random_strip(width, 29, 0, density, static_cast<unsigned>(width)).coverage;
      Plane<uint8_t> alpha(width, 29), wanted(width, 29);
      for (size_t i = 0; i < alpha.samples.size(); ++i) {
        const uint32_t kind = random() % 4;
        alpha.samples[i] = static_cast<uint8_t>(kind == 0 ? 0 : kind < 3 ? 255 : random());
        wanted.samples[i] = coverage.samples[i] ? alpha.samples[i] : uint8_t{0};
      }
      const std::vector<uint8_t> bytes = encode_alpha_strip(coverage, alpha);
      EXPECT_EQ(decode_alpha_strip(bytes, kPlace, coverage), wanted) << width << ", " << density;
      if (density == 0) continue;
      std::vector<uint8_t> longer = bytes;
      longer.insert(longer.end(), 6, 0);
      EXPECT_NE(refusal([&] { decode_alpha_strip(longer, kPlace, coverage); }), "");
    }
}

// --- guided colour ---------------------------------------------------------------------------------------------------

// Thin slanted lines of one colour before another.
RgbImage twigs(int width, int height, Rgb twig, Rgb sky) {
  RgbImage image(width, height, sky);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if ((3 * x + y) % 19 < 4 || (x - 2 * y + 4096) % 23 < 3) image.at(x, y) = twig;
  return image;
}

RgbImage through_webp(const RgbImage& image) { return decode_image(encode_webp(image, 100), "a"); }

TEST(GuidedColour, GetsBackTheColoursOfThingsThinnerThanABlock) {
  const RgbImage image = twigs(64, 48, {60, 50, 30}, {130, 170, 220}), coded = through_webp(image);
  EXPECT_GT(rms(coded, image), 12);
  EXPECT_LT(rms(guide_colour(coded), image), 5);
}

TEST(GuidedColour, LeavesWhatHasOneColourOrOneLightness) {
  const RgbImage plain(32, 16, {90, 140, 200});
  EXPECT_EQ(guide_colour(plain), plain);
  // Red and green as light as each other: luma cannot tell where one ends, what came is kept.
  RgbImage even(32, 16, {150, 90, 60});
  for (int y = 0; y < 16; ++y) std::fill_n(even.row(y) + 13, 19, Rgb{60, 136, 60});
  EXPECT_LT(rms(guide_colour(even), even), 1.5);
}

TEST(GuidedColour, LumaStays) {
  const RgbImage image = through_webp(twigs(64, 48, {40, 120, 60}, {200, 180, 150}));
  const RgbImage guided = guide_colour(image);
  for (size_t i = 0; i < image.samples.size(); ++i) {
    const auto luma = [](Rgb c) { return .299 * c.r + .587 * c.g + .114 * c.b; };
    ASSERT_NEAR(luma(guided.samples[i]), luma(image.samples[i]), 1.5) << i;
  }
}

TEST(GuidedColour, WhatIsMadeForItComesBackCloser) {
  const RgbImage image = twigs(64, 48, {90, 60, 20}, {120, 160, 240});
  const double without = rms(guide_colour(through_webp(image)), image);
  const double made = rms(guide_colour(through_webp(made_for_guiding(image))), image);
  EXPECT_LT(made, .97 * without) << made << " instead of " << without;
}

TEST(GuidedColour, TheSmallestImagesHaveNeighboursToo) {
  const RgbImage image = twigs(2, 2, {90, 60, 20}, {120, 160, 240});
  EXPECT_EQ(guide_colour(image).samples.size(), 4U);
  EXPECT_EQ(made_for_guiding(image).samples.size(), 4U);
}

}  // namespace
}  // namespace ldp::file
