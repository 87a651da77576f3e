#include "mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace ldp::render {
namespace {

// What a slanted surface may change from one pixel to the next: a share of its inverse depth (a surface seen at 88.5
// degrees from its normal) plus this many pixels of parallax over one arc radius.
constexpr float kSlant = 0.02F;
constexpr double kParallaxPx = 1.5;

void check(const Layer& layer, const PanoramaGrid& grid, size_t index) {
  const auto fits = [&](const auto& plane) { return plane.width == grid.width && plane.height == grid.height; };
  if (!fits(layer.depth.codes) || !fits(layer.coverage) || !fits(layer.colour) ||
      (!layer.alpha.empty() && !fits(layer.alpha)))
    throw std::logic_error("Renderer: layer " + std::to_string(index) + " is not as large as the panorama");
}

// Largest error of each pixel's inverse depth that comes from its code alone.
float code_step(const PanoramaGrid& grid, const DepthCodes& depth, int x, int y) {
  const BlockRange range =
      depth.block_px == 0 ? depth.ranges.samples[0] : depth.ranges.at(x / depth.block_px, y / depth.block_px);
  return static_cast<float>((grid.w_near - grid.w_far) * (range.high - range.low) / kDisparitySteps);
}

struct PreparedLayer {
  MeshLayer mesh;
  Plane<float> step;  // difference of inverse depth between neighbouring codes
};

PreparedLayer prepare_layer(const PanoramaGrid& grid, const Layer& layer) {
  const int columns = grid.wraps ? grid.width + 1 : grid.width;
  PreparedLayer prepared{{Plane<float>(columns, grid.height, kAbsent), Plane<Rgba>(columns, grid.height)},
                         Plane<float>(columns, grid.height)};
  for (int y = 0; y < grid.height; ++y)
    for (int column = 0; column < columns; ++column) {
      const int x = column == grid.width ? 0 : column;
      if (!layer.coverage.at(x, y)) continue;
      const uint8_t alpha = layer.alpha.empty() ? uint8_t{255} : layer.alpha.at(x, y);
      prepared.mesh.w.at(column, y) = static_cast<float>(grid.inverse_depth(layer.depth.disparity(x, y)));
      prepared.mesh.colour.at(column, y) = pack(layer.colour.at(x, y), alpha);
      prepared.step.at(column, y) = code_step(grid, layer.depth, x, y);
    }
  return prepared;
}

// One corner of a quad in one layer.
struct Corner {
  float w = kAbsent, step = 0;
  Rgba colour = 0;
  bool present() const { return w >= 0; }
};
using Corners = std::array<Corner, 4>;

class Builder {
 public:
  explicit Builder(const LayeredPanorama& panorama);
  Mesh build();

 private:
  MeshTile build_tile(int layer, int x0, int y0) const;
  void build_quad(MeshTile& tile, int x, int y) const;
  void add_surface(MeshTile& tile, const std::array<int, 4>& surface, int wanted, int x, int y) const;
  Corner extend(int layer, const Corner& from, int x, int y) const;
  Corner corner(int layer, int x, int y) const;
  std::array<int, 4> group(const Corners& corners) const;
  bool connected(const Corner& a, const Corner& b) const {
    if (!a.present() || !b.present()) return false;
    return std::abs(a.w - b.w) <= 0.51F * (a.step + b.step) + kSlant * std::max(a.w, b.w) + parallax_;
  }

  const PanoramaGrid& grid_;
  std::vector<PreparedLayer> layers_;
  float parallax_;
};

Builder::Builder(const LayeredPanorama& panorama) : grid_(panorama.grid) {
  for (size_t i = 0; i < panorama.layers.size(); ++i) {
    check(panorama.layers[i], grid_, i);
    layers_.push_back(prepare_layer(grid_, panorama.layers[i]));
  }
  const double radius = grid_.arc.radius > 0 ? grid_.arc.radius : 1;
  parallax_ = static_cast<float>(kParallaxPx * grid_.v_pitch / radius);
}

Corner Builder::corner(int layer, int x, int y) const {
  const PreparedLayer& from = layers_[static_cast<size_t>(layer)];
  const size_t i = from.step.index(x, y);
  return {from.mesh.w.samples[i], from.step.samples[i], from.mesh.colour.samples[i]};
}

// Surfaces of a quad: the index of a corner's surface is its first corner's; -1 = absent.
std::array<int, 4> Builder::group(const Corners& c) const {
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
  for (int other = 0; other < static_cast<int>(layers_.size()); ++other) {
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

void Builder::add_surface(MeshTile& tile, const std::array<int, 4>& surface, int wanted, int x, int y) const {
  // Where a missing corner is extended from: its neighbours along the quad's sides, then the opposite corner.
  constexpr std::array<std::array<size_t, 3>, 4> kNeighbours = {{{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}}};
  TornQuad quad;
  quad.x_in_tile = static_cast<uint8_t>(x - tile.x0);
  quad.y_in_tile = static_cast<uint8_t>(y - tile.y0);
  for (size_t i = 0; i < 4; ++i) {
    const auto at = [&](size_t k) {
      return corner(tile.layer, x + static_cast<int>(k & 1), y + static_cast<int>(k >> 1));
    };
    Corner c = at(i);
    if (surface[i] != wanted) {
      size_t source = 0;
      while (surface[kNeighbours[i][source]] != wanted) ++source;
      const size_t k = kNeighbours[i][source];
      c = extend(tile.layer, at(k), x + static_cast<int>(i & 1), y + static_cast<int>(i >> 1));
    }
    quad.w[i] = c.w;
    quad.colour[i] = c.colour;
    quad.soft |= alpha_of(c.colour) != 255;
  }
  tile.torn.push_back(quad);
}

void Builder::build_quad(MeshTile& tile, int x, int y) const {
  Corners c;
  for (int i = 0; i < 4; ++i) c[static_cast<size_t>(i)] = corner(tile.layer, x + (i & 1), y + (i >> 1));
  const std::array<int, 4> surface = group(c);
  const bool whole = surface == std::array<int, 4>{0, 0, 0, 0};
  const bool opaque = std::all_of(c.begin(), c.end(), [](const Corner& k) { return alpha_of(k.colour) == 255; });
  if (whole && opaque) {
    tile.solid[y - tile.y0] |= 1U << (x - tile.x0);
    return;
  }
  for (int s = 0; s < 4; ++s)
    if (surface[static_cast<size_t>(s)] == s) add_surface(tile, surface, s, x, y);
}

MeshTile Builder::build_tile(int layer, int x0, int y0) const {
  MeshTile tile;
  tile.layer = layer;
  tile.x0 = x0;
  tile.y0 = y0;
  const int x1 = std::min(x0 + kTilePx, grid_.wraps ? grid_.width : grid_.width - 1);
  const int y1 = std::min(y0 + kTilePx, grid_.height - 1);
  tile.w_min = INFINITY;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) build_quad(tile, x, y);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Corner c = corner(layer, x, y);
      if (!c.present()) continue;
      tile.w_min = std::min(tile.w_min, c.w);
      tile.w_max = std::max(tile.w_max, c.w);
    }
  for (const TornQuad& quad : tile.torn)
    for (const float w : quad.w) {
      tile.w_min = std::min(tile.w_min, w);
      tile.w_max = std::max(tile.w_max, w);
    }
  const auto soft =
      std::stable_partition(tile.torn.begin(), tile.torn.end(), [](const TornQuad& q) { return !q.soft; });
  tile.opaque_torn = static_cast<size_t>(soft - tile.torn.begin());
  return tile;
}

Mesh Builder::build() {
  Mesh mesh;
  for (int layer = 0; layer < static_cast<int>(layers_.size()); ++layer)
    for (int y0 = 0; y0 + 1 < grid_.height; y0 += kTilePx)
      for (int x0 = 0; x0 < (grid_.wraps ? grid_.width : grid_.width - 1); x0 += kTilePx) {
        MeshTile tile = build_tile(layer, x0, y0);
        const bool any =
            std::any_of(std::begin(tile.solid), std::end(tile.solid), [](uint32_t row) { return row != 0; });
        if (any || !tile.torn.empty()) mesh.tiles.push_back(std::move(tile));
      }
  for (PreparedLayer& layer : layers_) mesh.layers.push_back(std::move(layer.mesh));
  return mesh;
}

}  // namespace

Mesh build_mesh(const LayeredPanorama& panorama) { return Builder(panorama).build(); }

}  // namespace ldp::render
