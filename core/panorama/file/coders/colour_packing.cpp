#include "core/panorama/file/coders/colour_packing.h"

namespace ldp::file {
namespace {

// Three quarters: below, the pixels that a whole tile would have to invent cost more than what the curve loses of their
// neighbourhood (leaves: 13.4 bits a pixel whole, 9.5, 8.7, 8.7 with bounds of 128, 192, 256).
constexpr int kLeastOfWhole = 192;

Plane<uint16_t> count_present(const DepthStrip& strip) {
  Plane<uint16_t> present(strip.tiles.width, strip.tiles.height);
  for (int y = 0; y < strip.coverage.height; ++y)
    for (int x = 0; x < strip.coverage.width; ++x)
      present.at(x / kTile, y / kTile) =
          static_cast<uint16_t>(present.at(x / kTile, y / kTile) + strip.coverage.at(x, y));
  return present;
}

}  // namespace

ColourPacking::ColourPacking(const DepthStrip& strip, ColourLayout layout)
    : strip_(strip), least_(layout == ColourLayout::plain ? 0 : kLeastOfWhole), present_(count_present(strip)) {
  for (int ty = 0; ty < strip.tiles.height; ++ty)
    for (int tx = 0; tx < strip.tiles.width; ++tx) {
      if (is_whole(tx, ty))
        ++whole_;
      else if (strip.tiles.at(tx, ty) != TileState::empty)
        loose_ += present_.at(tx, ty);
    }
}

ImageSize ColourPacking::size() const {
  const int64_t tiles = whole_ + (loose_ + kTilePixels - 1) / kTilePixels;
  const auto rows = static_cast<int>((tiles + strip_.tiles.width - 1) / strip_.tiles.width);
  return {strip_.tiles.width * kTile, rows * kTile};
}

}  // namespace ldp::file
