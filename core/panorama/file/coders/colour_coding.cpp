#include "core/panorama/file/coders/colour_coding.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <functional>
#include <string_view>

#include "core/panorama/file/coders/colour_packing.h"
#include "core/panorama/file/coders/guided_colour.h"
#include "core/photos/images.h"

namespace ldp::file {
namespace {

constexpr int kLossless = 101;

struct Tile {
  std::array<Rgb, kTilePixels> pixels{};
  std::bitset<kTilePixels> known;
};

Rgb mean_of_known(const Tile& tile) {
  int r = 0, g = 0, b = 0;
  const int count = std::max(1, static_cast<int>(tile.known.count()));
  for (size_t i = 0; i < kTilePixels; ++i) {
    if (!tile.known[i]) continue;
    r += tile.pixels[i].r, g += tile.pixels[i].g, b += tile.pixels[i].b;
  }
  return {static_cast<uint8_t>(r / count), static_cast<uint8_t>(g / count), static_cast<uint8_t>(b / count)};
}

Rgb mean_of_neighbours(const Tile& tile, int x, int y) {
  int r = 0, g = 0, b = 0, count = 0;
  const auto add = [&](int nx, int ny) {
    if (nx < 0 || ny < 0 || nx >= kTile || ny >= kTile) return;
    const Rgb c = tile.pixels[static_cast<size_t>(ny * kTile + nx)];
    r += c.r, g += c.g, b += c.b, ++count;
  };
  add(x - 1, y), add(x + 1, y), add(x, y - 1), add(x, y + 1);
  const int neighbours = std::max(count, 1);  // two at least
  const auto mean = [neighbours](int sum) { return static_cast<uint8_t>((sum + neighbours / 2) / neighbours); };
  return {mean(r), mean(g), mean(b)};
}

// The smoothest continuation of what is known (Laplace's equation by relaxation, forwards and backwards in turn): few
// coefficients for a transform codec, and no step at the silhouette.
void fill_unknown(Tile& tile) {
  if (tile.known.all()) return;
  constexpr int kSweeps = 12;
  const Rgb mean = mean_of_known(tile);
  for (size_t i = 0; i < kTilePixels; ++i)
    if (!tile.known[i]) tile.pixels[i] = mean;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int step = 0; step < kTilePixels; ++step) {
      const int i = sweep % 2 == 0 ? step : kTilePixels - 1 - step;
      if (!tile.known[static_cast<size_t>(i)])
        tile.pixels[static_cast<size_t>(i)] = mean_of_neighbours(tile, i % kTile, i / kTile);
    }
}

Tile cut(const RgbImage& packed, const Plane<uint8_t>& known, int x0, int y0) {
  Tile tile;
  for (int y = 0; y < kTile; ++y)
    for (int x = 0; x < kTile; ++x) {
      const auto i = static_cast<size_t>(y * kTile + x);
      tile.pixels[i] = packed.at(x0 + x, y0 + y);
      tile.known[i] = known.at(x0 + x, y0 + y) != 0;
    }
  return tile;
}

RgbImage pack(const ColourPacking& packing, const RgbImage& colour) {
  const ImageSize size = packing.size();
  RgbImage packed(size.width, size.height);
  Plane<uint8_t> known(size.width, size.height);
  packing.for_each_pixel([&](int x, int y, int packed_x, int packed_y) {
    packed.at(packed_x, packed_y) = colour.at(x, y);
    known.at(packed_x, packed_y) = 1;
  });
  Rgb last{};
  for (int y0 = 0; y0 < size.height; y0 += kTile)
    for (int x0 = 0; x0 < size.width; x0 += kTile) {
      Tile tile = cut(packed, known, x0, y0);
      if (tile.known.none())
        tile.pixels.fill(last);
      else
        fill_unknown(tile);
      last = tile.known.none() ? last : mean_of_known(tile);
      for (int y = 0; y < kTile; ++y)
        std::copy_n(&tile.pixels[static_cast<size_t>(y * kTile)], kTile, packed.row(y0 + y) + x0);
    }
  return packed;
}

RgbImage unpack(const ColourPacking& packing, const DepthStrip& strip, const RgbImage& packed) {
  RgbImage colour(strip.coverage.width, strip.coverage.height);
  packing.for_each_pixel(
      [&](int x, int y, int packed_x, int packed_y) { colour.at(x, y) = packed.at(packed_x, packed_y); });
  return colour;
}

struct Coded {
  ColourCodec codec;
  std::vector<uint8_t> image;
};

LdpCodec codec_of(const LdpEncodeOptions& options) {
  if (options.codec != LdpCodec::none) return options.codec;
  constexpr int kJpegFrom = 97;
  return options.colour_quality >= kJpegFrom && options.colour_quality < kLossless ? LdpCodec::jpeg : LdpCodec::webp;
}

Coded encode_plain(const RgbImage& packed, LdpCodec codec, int quality) {
  if (codec == LdpCodec::jpeg) return {ColourCodec::jpeg, encode_jpeg(packed, quality)};
  if (quality == kLossless) return {ColourCodec::webp, encode_webp_lossless(packed)};
  return {ColourCodec::webp, encode_webp(made_for_guiding(packed), quality)};
}

bool is_webp_of(std::string_view first_chunk, std::span<const uint8_t> image) {
  return image.size() >= 16 && std::ranges::equal(image.subspan(12, 4), first_chunk);
}

bool is_lossy_webp(std::span<const uint8_t> image) { return is_webp_of("VP8 ", image); }

RgbImage decode_packed(std::span<const uint8_t> image, const std::string& name) {
  RgbImage packed = decode_image(image, name);
  return is_lossy_webp(image) ? guide_colour(packed) : packed;
}

uint64_t squared_error(const ColourPacking& packing, const RgbImage& packed, std::span<const uint8_t> image) {
  const RgbImage back = decode_packed(image, "packed colour");
  const auto square = [](int d) { return static_cast<uint64_t>(d * d); };
  uint64_t sum = 0;
  packing.for_each_pixel([&](int, int, int x, int y) {
    const Rgb a = packed.at(x, y), b = back.at(x, y);
    sum += square(a.r - b.r) + square(a.g - b.g) + square(a.b - b.b);
  });
  return sum;
}

// The smallest JPEG file with no more error than `most`; empty if there is none. Gathered pixels change from one to the
// next, their colours too, so that these are kept at full resolution (WebP cannot: it needs twice the bytes).
std::vector<uint8_t> encode_gathered_jpeg(const ColourPacking& packing, const RgbImage& packed, uint64_t most) {
  std::vector<uint8_t> best;
  for (int low = 20, high = 100; low <= high;) {
    const int quality = (low + high) / 2;
    std::vector<uint8_t> image = encode_jpeg_444(packed, quality);
    if (squared_error(packing, packed, image) <= most) {
      best = std::move(image);
      high = quality - 1;
    } else {
      low = quality + 1;
    }
  }
  return best;
}

// The same colours gathered, as exact to 0.26 dB (steps of JPEG's quality are up to 1 dB), if that is allowed and there
// may be anything to gain.
Coded encode_gathered(const DepthStrip& strip, const RgbImage& colour, const LdpEncodeOptions& options,
                      const std::function<uint64_t()>& error_of_plain) {
  const ColourPacking packing(strip, ColourLayout::gathered);
  const bool lossless = options.colour_quality == kLossless;
  const bool dense = packing.gathered_pixels() * 8 < int64_t{packing.whole_tiles()} * kTilePixels;
  if (dense || (!lossless && options.codec == LdpCodec::webp)) return {};
  const RgbImage packed = pack(packing, colour);
  if (lossless) return {ColourCodec::webp_gathered, encode_webp_lossless(packed)};
  return {ColourCodec::jpeg_gathered, encode_gathered_jpeg(packing, packed, error_of_plain() * 17 / 16)};
}

bool is_jpeg_codec(ColourCodec codec) { return codec == ColourCodec::jpeg || codec == ColourCodec::jpeg_gathered; }

bool has_magic(std::span<const uint8_t> image, ColourCodec codec) {
  const uint8_t first = is_jpeg_codec(codec) ? 0xFF : 'R';
  return !image.empty() && image[0] == first;
}

ColourCodec read_codec(ByteReader& reader, int version) {
  return static_cast<ColourCodec>(reader.choice("codec", version == 1 ? 2 : 4));
}

ColourLayout layout_of(ColourCodec codec) {
  return codec >= ColourCodec::jpeg_gathered ? ColourLayout::gathered : ColourLayout::plain;
}

}  // namespace

std::vector<uint8_t> encode_colour_strip(const DepthStrip& strip, const RgbImage& colour,
                                         const LdpEncodeOptions& options) {
  const ColourPacking plain(strip, ColourLayout::plain);
  Coded best{ColourCodec::none, {}};
  if (plain.size().height > 0) {
    const RgbImage packed = pack(plain, colour);
    best = encode_plain(packed, codec_of(options), options.colour_quality);
    Coded gathered = encode_gathered(strip, colour, options, [&] { return squared_error(plain, packed, best.image); });
    if (!gathered.image.empty() && gathered.image.size() < best.image.size()) best = std::move(gathered);
  }
  ByteWriter out;
  out.u8(static_cast<uint8_t>(best.codec));
  out.append(best.image);
  return out.bytes;
}

int version_of_colour(std::span<const uint8_t> bytes) {
  return !bytes.empty() && layout_of(static_cast<ColourCodec>(bytes[0])) == ColourLayout::gathered ? 2 : 1;
}

std::optional<ColourCoding> coding_of_colour(std::span<const uint8_t> bytes, const Place& place, int version) {
  ByteReader reader(bytes, place);
  const ColourCodec codec = read_codec(reader, version);
  if (codec == ColourCodec::none) return std::nullopt;
  if (is_jpeg_codec(codec)) return ColourCoding::jpeg;
  return is_webp_of("VP8L", reader.take(reader.left())) ? ColourCoding::webp_lossless : ColourCoding::webp;
}

RgbImage decode_colour_strip(std::span<const uint8_t> bytes, const Place& place, const DepthStrip& strip, int version) {
  ByteReader reader(bytes, place);
  const ColourCodec codec = read_codec(reader, version);
  const ColourPacking packing(strip, layout_of(codec));
  const ImageSize expected = packing.size();
  const bool any = std::any_of(strip.tiles.samples.begin(), strip.tiles.samples.end(),
                               [](TileState tile) { return tile != TileState::empty; });
  if ((codec == ColourCodec::none) == any)
    place.refuse("codec", any ? "1 or more (tiles are stored)" : "0 (no tile is stored)",
                 std::to_string(static_cast<int>(codec)));
  if (codec == ColourCodec::none) {
    reader.expect_end();
    return RgbImage(strip.coverage.width, strip.coverage.height);
  }
  const auto image = reader.take(reader.left());
  if (!has_magic(image, codec)) place.refuse("its image", is_jpeg_codec(codec) ? "JPEG" : "WebP", "something else");
  try {
    const ImageSize found = image_size(image, "its image");
    if (found != expected)
      place.refuse("size of its image", std::to_string(expected.width) + " x " + std::to_string(expected.height),
                   std::to_string(found.width) + " x " + std::to_string(found.height));
    return unpack(packing, strip, decode_packed(image, "its image"));
  } catch (const LdpError&) {
    throw;
  } catch (const std::runtime_error& e) {
    place.refuse(e.what());
  }
}

}  // namespace ldp::file
