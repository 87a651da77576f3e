#include "core/view/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/view/mesh/code_smoother.h"
#include "core/view/mesh/frame_extension.h"
#include "core/view/mesh/prepared_layer.h"
#include "core/view/mesh/sparse_columns.h"
#include "core/view/mesh/torn_quads.h"
#include "core/view/mesh/underlay.h"
#include "core/view/tears.h"
#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

PreparedLayer prepare_layer(const PanoramaGrid& grid, const CodedDepths& depths, const Layer& layer) {
  PreparedLayer prepared{Plane<float>(grid.width, grid.height, kAbsent), Plane<Rgba>(grid.width, grid.height),
                         Plane<uint16_t>(grid.width, grid.height, kNoDisparity),
                         Plane<uint8_t>(grid.width, grid.height)};
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      if (!layer.coverage.at(x, y)) continue;
      const uint8_t alpha = layer.alpha.empty() ? uint8_t{255} : layer.alpha.at(x, y);
      const BlockRange range = layer.depth.range(x, y);
      prepared.code.at(x, y) = layer.depth.disparity(x, y);
      prepared.w.at(x, y) = depths.w(prepared.code.at(x, y));
      prepared.colour.at(x, y) = pack(layer.colour.at(x, y), alpha);
      prepared.step.at(x, y) = static_cast<uint8_t>(range.high - range.low);
    }
  return prepared;
}

// One corner of a quad in one layer.
struct Corner {
  float w = kAbsent, code_w = kAbsent, step = 0;
  Rgba colour = 0;
  bool present() const { return w >= 0; }
};
using Corners = std::array<Corner, 4>;

class Builder {
 public:
  explicit Builder(const PanoramaGrid& grid);
  void add(const Layer& layer);  // front to back
  Mesh build(const LayeredPanorama& panorama, int begin, int end, const Job& job);

 private:
  void add_made_up(const LayeredPanorama& panorama);
  void add_tiles(int layer, int begin, int end, const Job& job, Mesh& mesh) const;
  MeshTile build_tile(int layer, int x0, int y0, int x_end) const;
  void build_quad(const Corners& corners, int x, int y, MeshTile& tile, std::vector<TornQuad>& torn) const;
  void copy_vertices(MeshTile& tile) const;
  TornQuad torn_quad(const MeshTile& tile, const std::array<int, 4>& surface, int wanted, int x, int y) const;
  Corner extend(int layer, const Corner& from, int x, int y) const;
  Corner corner(int layer, int x, int y) const;
  bool absent(int layer, int x0, int x1, int y) const;  // in columns [x0, x1]
  std::array<int, 4> group(const Corners& corners) const;
  bool connected(const Corner& a, const Corner& b) const {
    const float parallax = look_alike(rgb_of(a.colour), rgb_of(b.colour)) ? alike_parallax_ : parallax_;
    return view::connected(a.code_w, a.step, b.code_w, b.step, parallax);
  }

  // Layers are counted on from the panorama's to the underlay and to what is made up beyond the frames.
  int layer_count() const { return static_cast<int>(layers_.size() + beyond_.size()); }
  bool is_sparse(int layer) const { return static_cast<size_t>(layer) >= layers_.size(); }
  const SparseColumns& sparse(int layer) const { return beyond_[static_cast<size_t>(layer) - layers_.size()]; }
  SparseColumns::Rows rows(int layer) const {
    return is_sparse(layer) ? sparse(layer).rows() : SparseColumns::Rows{0, grid_.height};
  }

  PanoramaGrid grid_;
  CodedDepths depths_;
  std::vector<PreparedLayer> layers_;
  std::vector<SparseColumns> beyond_;
  float parallax_ = 0, alike_parallax_ = 0;
};

Builder::Builder(const PanoramaGrid& grid) : grid_(grid), depths_(grid) {
  parallax_ = static_cast<float>(surface_slack(grid_));
  alike_parallax_ = static_cast<float>(surface_slack(grid_, kAlikeParallaxPx));
}

void Builder::add(const Layer& layer) {
  layers_.push_back(prepare_layer(grid_, depths_, layer));
  // With one range for all, neighbouring codes are as often two surfaces as one.
  if (layer.depth.block_px != 0) smooth_codes(layers_.back(), depths_, parallax_);
}

Corner Builder::corner(int layer, int x, int y) const {
  if (is_sparse(layer)) {
    const SparsePixel pixel = sparse(layer).at(x, y);
    return {pixel.w, depths_.w(pixel.code), depths_.step(pixel.step), pixel.colour};
  }
  const PreparedLayer& from = layers_[static_cast<size_t>(layer)];
  if (!from.step.contains(x, y)) return {};
  const size_t i = from.step.index(x, y);
  return {from.w.samples[i], depths_.w(from.code.samples[i]), depths_.step(from.step.samples[i]),
          from.colour.samples[i]};
}

bool Builder::absent(int layer, int x0, int x1, int y) const {
  if (is_sparse(layer)) return false;  // or true, which is as good
  const float* w = layers_[static_cast<size_t>(layer)].w.row(y);
  float nearest = kAbsent;
  for (int x = x0; x <= x1; ++x) nearest = std::max(nearest, w[x]);
  return nearest < 0;
}

// Surfaces of a quad: the index of a corner's surface is its first corner's; -1 = absent.
std::array<int, 4> Builder::group(const Corners& c) const {
  if (std::none_of(c.begin(), c.end(), [](const Corner& k) { return k.present(); })) return {-1, -1, -1, -1};
  if (connected(c[0], c[1]) && connected(c[0], c[2]) && connected(c[1], c[3])) return {0, 0, 0, 0};
  std::array<int, 4> surface = {0, 1, 2, 3};
  const auto join = [&](int a, int b) {
    if (!connected(c[static_cast<size_t>(a)], c[static_cast<size_t>(b)])) return;
    const int from = std::max(surface[static_cast<size_t>(a)], surface[static_cast<size_t>(b)]);
    const int to = std::min(surface[static_cast<size_t>(a)], surface[static_cast<size_t>(b)]);
    for (int& s : surface)
      if (s == from) s = to;
  };
  join(0, 1), join(0, 2), join(1, 3), join(2, 3), join(0, 3), join(1, 2);
  for (size_t i = 0; i < 4; ++i)
    if (!c[i].present()) surface[i] = -1;
  return surface;
}

// The corner (x, y) that `from`, next to it, would have if its surface went on.
Corner Builder::extend(int layer, const Corner& from, int x, int y) const {
  Corner best;
  bool hidden = false;
  for (int other = 0; other < layer_count(); ++other) {
    const Corner c = corner(other, x, y);
    if (!c.present()) continue;
    if (other != layer && connected(from, c) && (!best.present() || std::abs(c.w - from.w) < std::abs(best.w - from.w)))
      best = c;
    hidden |= c.w > from.w;
  }
  if (best.present()) return best;
  best = from;
  if (!hidden) best.colour &= 0x00FFFFFFU;
  return best;
}

TornQuad Builder::torn_quad(const MeshTile& tile, const std::array<int, 4>& surface, int wanted, int x, int y) const {
  // Where a missing corner is extended from: its neighbours along the quad's sides, then the opposite corner.
  constexpr std::array<std::array<size_t, 3>, 4> kNeighbours = {{{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}}};
  TornQuad quad;
  const auto at = [&](size_t k) {
    return corner(tile.layer, x + static_cast<int>(k & 1), y + static_cast<int>(k >> 1));
  };
  for (size_t i = 0; i < 4; ++i) {
    Corner c = at(i);
    if (surface[i] != wanted) {
      size_t source = 0;
      while (surface[kNeighbours[i][source]] != wanted) ++source;
      const size_t k = kNeighbours[i][source];
      c = extend(tile.layer, at(k), x + static_cast<int>(i & 1), y + static_cast<int>(i >> 1));
    }
    const auto x_in_tile = static_cast<size_t>(x - tile.x0) + (i & 1);
    const auto y_in_tile = static_cast<size_t>(y - tile.y0) + (i >> 1);
    quad.corners[i] = {static_cast<uint8_t>(x_in_tile), static_cast<uint8_t>(y_in_tile), c.w, c.colour};
  }
  return quad;
}

void Builder::build_quad(const Corners& c, int x, int y, MeshTile& tile, std::vector<TornQuad>& torn) const {
  const std::array<int, 4> surface = group(c);
  const bool whole = surface == std::array<int, 4>{0, 0, 0, 0};
  const bool opaque = std::all_of(c.begin(), c.end(), [](const Corner& k) { return alpha_of(k.colour) == 255; });
  if (whole && opaque) {
    tile.solid[y - tile.y0] |= 1U << (x - tile.x0);
    return;
  }
  for (int s = 0; s < 4; ++s)
    if (surface[static_cast<size_t>(s)] == s) torn.push_back(torn_quad(tile, surface, s, x, y));
}

void Builder::copy_vertices(MeshTile& tile) const {
  tile.w.assign(size_t{kTileVertices} * kTileVertices, kAbsent);
  tile.colour.assign(size_t{kTileVertices} * kTileVertices, 0);
  for (int y = 0; y < kTileVertices; ++y)
    for (int x = 0; x < kTileVertices; ++x) {
      const Corner c = corner(tile.layer, tile.x0 + x, tile.y0 + y);
      tile.w[MeshTile::index(x, y)] = c.w;
      tile.colour[MeshTile::index(x, y)] = c.colour;
    }
}

void find_ranges(MeshTile& tile, const std::vector<TornQuad>& torn) {
  std::fill_n(tile.cell_w_min, kCells, INFINITY);
  std::fill_n(tile.cell_w_max, kCells, kAbsent);
  const auto include = [&](int x_in_tile, int y_in_tile, float w) {
    const int cell = cell_of(x_in_tile, y_in_tile);
    tile.cell_w_min[cell] = std::min(tile.cell_w_min[cell], w);
    tile.cell_w_max[cell] = std::max(tile.cell_w_max[cell], w);
  };
  for (int y = 0; y < kTilePx; ++y)
    for (uint32_t bits = tile.solid[y]; bits != 0; bits &= bits - 1) {
      const int x = std::countr_zero(bits);
      for (int k = 0; k < 4; ++k) include(x, y, tile.w[MeshTile::index(x + (k & 1), y + (k >> 1))]);
    }
  for (const TornQuad& quad : torn)
    for (const TornVertex& corner : quad.corners)
      include(quad.corners[0].x_in_tile, quad.corners[0].y_in_tile, corner.w);
  tile.w_min = *std::min_element(tile.cell_w_min, tile.cell_w_min + kCells);
  tile.w_max = *std::max_element(tile.cell_w_max, tile.cell_w_max + kCells);
}

MeshTile Builder::build_tile(int layer, int x0, int y0, int x_end) const {
  MeshTile tile;
  tile.layer = layer;
  tile.x0 = x0;
  tile.y0 = y0;
  const int x1 = std::min(x0 + kTilePx, x_end);
  const int y1 = std::min(y0 + kTilePx, rows(layer).end - 1);
  if (is_sparse(layer) && !sparse(layer).any(x0, x1 + 1, y0, y1 + 1)) return tile;
  std::vector<TornQuad> torn;
  for (int y = y0; y < y1; ++y) {
    if (absent(layer, x0, x1, y) && absent(layer, x0, x1, y + 1)) continue;
    Corners c{{{}, corner(layer, x0, y), {}, corner(layer, x0, y + 1)}};
    for (int x = x0; x < x1; ++x) {
      c = {c[1], corner(layer, x + 1, y), c[3], corner(layer, x + 1, y + 1)};
      build_quad(c, x, y, tile, torn);
    }
  }
  if (std::any_of(std::begin(tile.solid), std::end(tile.solid), [](uint32_t row) { return row != 0; }))
    copy_vertices(tile);
  find_ranges(tile, torn);
  store_torn(std::move(torn), tile);
  return tile;
}

void Builder::add_made_up(const LayeredPanorama& panorama) {
  PreparedLayer underlay = make_underlay(layers_, depths_, parallax_);
  beyond_ = extend_beyond_frames(layers_.front(), depths_, panorama, parallax_);
  layers_.push_back(std::move(underlay));
}

void Builder::add_tiles(int layer, int begin, int end, const Job& job, Mesh& mesh) const {
  const SparseColumns::Rows in = rows(layer);
  const int across = (end - begin + kTilePx - 1) / kTilePx, down = (in.end - in.begin - 1 + kTilePx - 1) / kTilePx;
  std::vector<MeshTile> tiles(static_cast<size_t>(std::max(0, across * down)));
  parallel_for(job, static_cast<int>(tiles.size()), [&](int i) {
    MeshTile tile = build_tile(layer, begin + i % across * kTilePx, in.begin + i / across * kTilePx, end);
    tile.y0 -= mesh.first_row;
    tiles[static_cast<size_t>(i)] = std::move(tile);
  });
  for (MeshTile& tile : tiles)
    if (!tile.w.empty() || !tile.torn.empty()) mesh.tiles.push_back(std::move(tile));
}

Mesh Builder::build(const LayeredPanorama& panorama, int begin, int end, const Job& job) {
  Mesh mesh;
  mesh.layers = static_cast<int>(layers_.size());
  if (!layers_.empty()) add_made_up(panorama);
  int end_row = grid_.height;
  for (const SparseColumns& layer : beyond_) {
    mesh.first_row = std::min(mesh.first_row, layer.rows().begin);
    end_row = std::max(end_row, layer.rows().end);
  }
  mesh.rows = end_row - mesh.first_row;
  for (int layer = 0; layer < layer_count(); ++layer) add_tiles(layer, begin, end, job, mesh);
  return mesh;
}

}  // namespace

CodedDepths::CodedDepths(const PanoramaGrid& grid) {
  for (int code = 0; code <= kDisparitySteps; ++code)
    w_[static_cast<size_t>(code)] = static_cast<float>(grid.inverse_depth(code));
  for (int step = 0; step < 256; ++step)
    steps_[static_cast<size_t>(step)] = static_cast<float>((grid.w_near - grid.w_far) * step / kDisparitySteps);
}

void check_layers(const LayeredPanorama& panorama) {
  const PanoramaGrid& grid = panorama.grid;
  const auto fits = [&](const auto& plane) { return plane.width == grid.width && plane.height == grid.height; };
  for (size_t i = 0; i < panorama.layers.size(); ++i) {
    const Layer& layer = panorama.layers[i];
    if (!fits(layer.depth.codes) || !fits(layer.coverage) || !fits(layer.colour) ||
        (!layer.alpha.empty() && !fits(layer.alpha)))
      throw std::logic_error("Renderer: layer " + std::to_string(i) + " is not as large as the panorama");
  }
}

Mesh build_mesh(const LayeredPanorama& panorama, int begin, int end, const Job& job) {
  Builder builder(panorama.grid);
  for (const Layer& layer : panorama.layers) builder.add(layer);
  return builder.build(panorama, begin, std::min(end, panorama.grid.width - 1), job);
}

}  // namespace ldp::view
