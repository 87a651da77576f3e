// The layers of a panorama, or of some of its columns, as one mesh of small quads for any number of views.
//
// Vertices are the centres of present panorama pixels, lifted to their inverse depth w. A quad lies between four
// neighbouring pixels. Where all four belong to one surface the quad is solid. Where depth jumps the quad is torn: each
// surface that touches it becomes a quad of its own whose missing corners are, in this order,
//   - the pixel of another layer that continues the surface (so layers are sewn together without a seam),
//   - a copy of the neighbouring corner: opaque where something nearer hides it (the surface goes on underneath),
//     transparent where nothing nearer does (the silhouette fades over one pixel, which is exactly how bilinear
//     sampling of the source image would show it).
//
// Two neighbours tear when their inverse depths differ by more than their codes' resolution plus what a very slanted
// surface may change from pixel to pixel; where they look alike only when they differ by more (tears.h).
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/job.h"
#include "core/panorama/panorama.h"
#include "core/view/raster/raster_kernels.h"

namespace ldp::view {

constexpr int kTilePx = kRowQuads;          // quads per tile side; a row of a tile is one 32-bit mask
constexpr int kTileVertices = kTilePx + 1;  // vertices per tile side

inline Rgba pack(Rgb c, uint8_t a) {
  return static_cast<Rgba>(c.r) | static_cast<Rgba>(c.g) << 8 | static_cast<Rgba>(c.b) << 16 |
         static_cast<Rgba>(a) << 24;
}
inline uint32_t alpha_of(Rgba c) { return c >> 24; }
inline Rgb rgb_of(Rgba c) {
  return {static_cast<uint8_t>(c), static_cast<uint8_t>(c >> 8), static_cast<uint8_t>(c >> 16)};
}

constexpr float kAbsent = -1;  // inverse depth where a layer is not present

// A vertex of a torn place.
struct TornVertex {
  uint8_t x_in_tile = 0, y_in_tile = 0;
  float w = 0;
  Rgba colour = 0;
  bool operator==(const TornVertex&) const = default;
};

// A tile's quads in squares of kCellPx, row by row: what is skipped together when something nearer hides it.
constexpr int kCellPx = 8, kCellsAcross = kTilePx / kCellPx, kCells = kCellsAcross * kCellsAcross;
inline int cell_of(int x_in_tile, int y_in_tile) { return y_in_tile / kCellPx * kCellsAcross + x_in_tile / kCellPx; }

// Quads (x, y), x0 <= x < x0 + kTilePx, y0 <= y < y0 + kTilePx, of one layer.
struct MeshTile {
  int layer = 0, x0 = 0, y0 = 0;
  float w_min = 0, w_max = 0;
  float cell_w_min[kCells], cell_w_max[kCells];  // of all corners of its quads; of a cell without quads w_max < w_min
  uint32_t solid[kTilePx] = {};                  // bit i of solid[j]: quad (x0 + i, y0 + j) is solid and opaque

  // Of vertices (x0 + i, y0 + j), i and j up to kTilePx, row by row: what is drawn together lies together. Empty if no
  // quad is solid.
  std::vector<float> w;
  std::vector<Rgba> colour;
  static size_t index(int x_in_tile, int y_in_tile) {
    return static_cast<size_t>(y_in_tile * kTileVertices + x_in_tile);
  }

  // Opaque ones of cell 0, of cell 1 and so on, then soft ones of cell 0 and so on; quads of the i-th of these end at
  // torn_end[i] and share vertices, which end at torn_vertices_end[i]. A soft quad has a corner that is not opaque.
  std::vector<kernels::IndexedQuad> torn;
  std::vector<TornVertex> torn_vertices;
  uint16_t torn_end[2 * kCells] = {}, torn_vertices_end[2 * kCells] = {};
};

struct Mesh {
  int layers = 0;               // the panorama's; from there on the underlay and what lies beyond the photos' frames
  int first_row = 0, rows = 0;  // of the panorama, that vertices stand in; a tile's y0 counts from first_row
  std::vector<MeshTile> tiles;  // layer by layer, only those with a quad
};

// Of the quads whose left columns are [begin, end). The panorama's layers must be as large as it is; it must not wrap.
Mesh build_mesh(const LayeredPanorama& panorama, int begin, int end, const Job& job);

// Throws std::logic_error unless all layers are as large as the panorama.
void check_layers(const LayeredPanorama& panorama);

}  // namespace ldp::view
