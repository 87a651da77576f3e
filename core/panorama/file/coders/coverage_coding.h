// Which pixels of a strip are present: tiles that are empty, full or mixed, then the pixels of mixed ones.
//
// Runs in the encoder and in the decoder (depth_coding.cpp), which differ in Coder only.
#pragma once

#include <algorithm>
#include <array>

#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/coders/range_coder.h"

namespace ldp::file {

struct CoverageModels {
  std::array<std::array<BitModel, 2>, 81> tile;
  std::array<BitModel, 1024> pixel;
};

template <typename Coder>
void code_tiles(Coder& coder, CoverageModels& models, Plane<TileState>& tiles) {
  const auto state = [&](int x, int y) { return tiles.contains(x, y) ? static_cast<size_t>(tiles.at(x, y)) : 0; };
  for (int y = 0; y < tiles.height && !coder.ended(); ++y)
    for (int x = 0; x < tiles.width; ++x) {
      const size_t context = 27 * state(x - 1, y) + 9 * state(x, y - 1) + 3 * state(x - 1, y - 1) + state(x + 1, y - 1);
      TileState& tile = tiles.at(x, y);
      if (!coder.bit(models.tile[context][0], tile != TileState::empty))
        tile = TileState::empty;
      else
        tile = coder.bit(models.tile[context][1], tile == TileState::mixed) ? TileState::mixed : TileState::full;
    }
}

// Ten pixels around the one to be coded:   . c d e .      row y-2
//                                          f g h i j      row y-1
//                                          a b ?          row y
template <typename Coder>
void code_mixed_run(Coder& coder, CoverageModels& models, Plane<uint8_t>& coverage, int x0, int x1, int y) {
  const auto pixel = [&](int px, int py) { return coverage.contains(px, py) ? size_t{coverage.at(px, py)} : 0; };
  size_t above2 = pixel(x0 - 1, y - 2) << 1 | pixel(x0, y - 2);
  size_t above = pixel(x0 - 2, y - 1) << 3 | pixel(x0 - 1, y - 1) << 2 | pixel(x0, y - 1) << 1 | pixel(x0 + 1, y - 1);
  size_t left = pixel(x0 - 2, y) << 1 | pixel(x0 - 1, y);
  for (int x = x0; x < x1; ++x) {
    above2 = (above2 << 1 | pixel(x + 1, y - 2)) & 7;
    above = (above << 1 | pixel(x + 2, y - 1)) & 31;
    uint8_t& present = coverage.at(x, y);
    present = coder.bit(models.pixel[above2 << 7 | above << 2 | left], present != 0);
    left = (left << 1 | present) & 3;
  }
}

template <typename Coder>
void code_coverage(Coder& coder, Plane<TileState>& tiles, Plane<uint8_t>& coverage) {
  CoverageModels models;
  code_tiles(coder, models, tiles);
  for (int y = 0; y < coverage.height && !coder.ended(); ++y)
    for (int tx = 0; tx < tiles.width; ++tx) {
      const int x0 = tx * kTile;
      const int x1 = std::min(coverage.width, x0 + kTile);
      const TileState state = tiles.at(tx, y / kTile);
      if (state == TileState::mixed)
        code_mixed_run(coder, models, coverage, x0, x1, y);
      else
        std::fill(coverage.row(y) + x0, coverage.row(y) + x1, static_cast<uint8_t>(state == TileState::full));
    }
}

}  // namespace ldp::file
