// Where the present pixels of a strip are in the packed image that its COLR chunk holds (FORMAT.md, section 7).
//
// Plain: every tile with a present pixel, whole. Gathered: tiles of which most is present, whole; then the present
// pixels of all others, one after the other along a curve, so that a layer of scattered pixels takes no more room than
// they do.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/panorama/file/coders/depth_coding.h"
#include "core/photos/images.h"

namespace ldp::file {

enum class ColourLayout { plain, gathered };

struct CurvePoint {
  uint8_t x, y;
};

constexpr int kTilePixels = kTile * kTile;

// Hilbert's curve through a tile.
constexpr std::array<CurvePoint, kTilePixels> kTileCurve = [] {
  std::array<CurvePoint, kTilePixels> curve{};
  for (int i = 0; i < kTilePixels; ++i) {
    int x = 0, y = 0, rest = i;
    for (int side = 1; side < kTile; side *= 2, rest /= 4) {
      const int rx = 1 & (rest / 2);
      const int ry = 1 & (rest ^ rx);
      if (ry == 0) {
        const int turned_x = rx == 1 ? side - 1 - y : y;
        y = rx == 1 ? side - 1 - x : x;
        x = turned_x;
      }
      x += side * rx;
      y += side * ry;
    }
    curve[static_cast<size_t>(i)] = {static_cast<uint8_t>(x), static_cast<uint8_t>(y)};
  }
  return curve;
}();

class ColourPacking {
 public:
  ColourPacking(const DepthStrip& strip, ColourLayout layout);

  ImageSize size() const;                             // of the packed image
  int whole_tiles() const { return whole_; }          // stored as they are
  int64_t gathered_pixels() const { return loose_; }  // of the other tiles

  // Calls action(x, y, packed x, packed y) for every present pixel of the strip.
  template <typename Action>
  void for_each_pixel(Action action) const {
    int whole = 0;
    int64_t loose = 0;
    for (int ty = 0; ty < strip_.tiles.height; ++ty)
      for (int tx = 0; tx < strip_.tiles.width; ++tx) {
        if (is_whole(tx, ty)) {
          const PlaceInImage at = tile_place(whole++);
          for (int y = ty * kTile; y < std::min(strip_.coverage.height, (ty + 1) * kTile); ++y)
            for (int x = tx * kTile; x < std::min(strip_.coverage.width, (tx + 1) * kTile); ++x)
              if (strip_.coverage.at(x, y)) action(x, y, at.x + x - tx * kTile, at.y + y - ty * kTile);
        } else if (strip_.tiles.at(tx, ty) != TileState::empty) {
          for (const CurvePoint from : kTileCurve) {
            const int x = tx * kTile + from.x, y = ty * kTile + from.y;
            if (!strip_.coverage.contains(x, y) || !strip_.coverage.at(x, y)) continue;
            const PlaceInImage at = tile_place(whole_ + static_cast<int>(loose / kTilePixels));
            const CurvePoint to = kTileCurve[static_cast<size_t>(loose % kTilePixels)];
            action(x, y, at.x + to.x, at.y + to.y);
            ++loose;
          }
        }
      }
  }

 private:
  struct PlaceInImage {
    int x, y;
  };
  PlaceInImage tile_place(int index) const {
    return {index % strip_.tiles.width * kTile, index / strip_.tiles.width * kTile};
  }
  bool is_whole(int tx, int ty) const {
    return strip_.tiles.at(tx, ty) != TileState::empty && present_.at(tx, ty) >= least_;
  }

  const DepthStrip& strip_;
  int least_;                // present pixels of a tile that is stored whole
  Plane<uint16_t> present_;  // pixels of each tile
  int whole_ = 0;
  int64_t loose_ = 0;
};

}  // namespace ldp::file
