#include "colour_coding.h"

#include <algorithm>
#include <array>
#include <bitset>

#include "images.h"

namespace ldp {
namespace {

constexpr int kTilePixels = kTile * kTile;
constexpr int kLossless = 101;

struct Tile {
  std::array<Rgb, kTilePixels> pixels{};
  std::bitset<kTilePixels> known;
};

struct TilePlace {
  int tx, ty;              // in the strip
  int packed_x, packed_y;  // top left pixel in the packed image
};

// Calls action for every stored tile, in the order in which they are packed; gives their number.
template <typename Action>
int for_each_tile(const Plane<TileState>& tiles, Action action) {
  int count = 0;
  for (int ty = 0; ty < tiles.height; ++ty)
    for (int tx = 0; tx < tiles.width; ++tx) {
      if (tiles.at(tx, ty) == TileState::empty) continue;
      action(TilePlace{tx, ty, count % tiles.width * kTile, count / tiles.width * kTile});
      ++count;
    }
  return count;
}

ImageSize packed_size(const Plane<TileState>& tiles) {
  const int count = for_each_tile(tiles, [](const TilePlace&) {});
  return {tiles.width * kTile, (count + tiles.width - 1) / tiles.width * kTile};
}

Tile cut(const DepthStrip& strip, const RgbImage& colour, int tx, int ty) {
  Tile tile;
  for (int y = 0; y < kTile; ++y)
    for (int x = 0; x < kTile; ++x) {
      const int from_x = tx * kTile + x;
      const int from_y = ty * kTile + y;
      if (!colour.contains(from_x, from_y) || !strip.coverage.at(from_x, from_y)) continue;
      const auto i = static_cast<size_t>(y * kTile + x);
      tile.pixels[i] = colour.at(from_x, from_y);
      tile.known[i] = true;
    }
  return tile;
}

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
  const auto mean = [count](int sum) { return static_cast<uint8_t>((sum + count / 2) / count); };
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

RgbImage pack(const DepthStrip& strip, const RgbImage& colour) {
  const ImageSize size = packed_size(strip.tiles);
  RgbImage packed(size.width, size.height);
  Tile tile;
  const auto put = [&](int x0, int y0) {
    for (int y = 0; y < kTile; ++y)
      std::copy_n(&tile.pixels[static_cast<size_t>(y * kTile)], kTile, packed.row(y0 + y) + x0);
  };
  const int count = for_each_tile(strip.tiles, [&](const TilePlace& place) {
    tile = cut(strip, colour, place.tx, place.ty);
    fill_unknown(tile);
    put(place.packed_x, place.packed_y);
  });
  tile.pixels.fill(mean_of_known(tile));
  for (int i = count; i < size.height / kTile * strip.tiles.width; ++i)
    put(i % strip.tiles.width * kTile, i / strip.tiles.width * kTile);
  return packed;
}

RgbImage unpack(const DepthStrip& strip, const RgbImage& packed) {
  RgbImage colour(strip.coverage.width, strip.coverage.height);
  for_each_tile(strip.tiles, [&](const TilePlace& place) {
    const int x0 = place.tx * kTile;
    const int y0 = place.ty * kTile;
    for (int y = y0; y < std::min(y0 + kTile, colour.height); ++y)
      for (int x = x0; x < std::min(x0 + kTile, colour.width); ++x)
        if (strip.coverage.at(x, y)) colour.at(x, y) = packed.at(place.packed_x + x - x0, place.packed_y + y - y0);
  });
  return colour;
}

LdpCodec codec_of(const LdpEncodeOptions& options) {
  if (options.codec != LdpCodec::none) return options.codec;
  constexpr int kJpegFrom = 95;
  return options.colour_quality >= kJpegFrom && options.colour_quality < kLossless ? LdpCodec::jpeg : LdpCodec::webp;
}

std::vector<uint8_t> encode_image(const RgbImage& image, LdpCodec codec, int quality) {
  if (codec == LdpCodec::jpeg) return encode_jpeg(image, quality);
  return quality == kLossless ? encode_webp_lossless(image) : encode_webp(image, quality);
}

bool has_magic(std::span<const uint8_t> image, LdpCodec codec) {
  const uint8_t first = codec == LdpCodec::jpeg ? 0xFF : 'R';
  return !image.empty() && image[0] == first;
}

}  // namespace

std::vector<uint8_t> encode_colour_strip(const DepthStrip& strip, const RgbImage& colour,
                                         const LdpEncodeOptions& options) {
  const RgbImage packed = pack(strip, colour);
  ByteWriter out;
  if (packed.empty()) {
    out.u8(static_cast<uint8_t>(LdpCodec::none));
    return out.bytes;
  }
  const LdpCodec codec = codec_of(options);
  out.u8(static_cast<uint8_t>(codec));
  out.append(encode_image(packed, codec, options.colour_quality));
  return out.bytes;
}

RgbImage decode_colour_strip(std::span<const uint8_t> bytes, const Place& place, const DepthStrip& strip) {
  ByteReader reader(bytes, place);
  const auto codec = static_cast<LdpCodec>(reader.choice("codec", 2));
  const ImageSize expected = packed_size(strip.tiles);
  if ((codec == LdpCodec::none) != (expected.height == 0))
    place.refuse("codec", expected.height == 0 ? "0 (no tile is stored)" : "1 or 2 (tiles are stored)",
                 std::to_string(static_cast<int>(codec)));
  if (codec == LdpCodec::none) {
    reader.expect_end();
    return RgbImage(strip.coverage.width, strip.coverage.height);
  }
  const auto image = reader.take(reader.left());
  if (!has_magic(image, codec)) place.refuse("its image", codec == LdpCodec::jpeg ? "JPEG" : "WebP", "something else");
  try {
    const ImageSize found = image_size(image, "its image");
    if (found != expected)
      place.refuse("size of its image", std::to_string(expected.width) + " x " + std::to_string(expected.height),
                   std::to_string(found.width) + " x " + std::to_string(found.height));
    return unpack(strip, decode_image(image, "its image"));
  } catch (const LdpError&) {
    throw;
  } catch (const std::runtime_error& e) {
    place.refuse(e.what());
  }
}

}  // namespace ldp
