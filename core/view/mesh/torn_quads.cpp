#include "core/view/mesh/torn_quads.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace ldp::view {
namespace {

int group_of(const TornQuad& quad) {
  const bool soft = std::any_of(std::begin(quad.corners), std::end(quad.corners),
                                [](const TornVertex& corner) { return alpha_of(corner.colour) != 255; });
  return (soft ? kCells : 0) + cell_of(quad.corners[0].x_in_tile, quad.corners[0].y_in_tile);
}

// Vertices of one group of quads, none twice.
class SharedVertices {
 public:
  explicit SharedVertices(std::vector<TornVertex>& vertices) : vertices_(vertices), before_(vertices.size(), kNone) {}

  void begin_group() { std::fill_n(&last_[0][0], kTileVertices * kTileVertices, kNone); }

  uint16_t index_of(const TornVertex& vertex) {
    int& last = last_[vertex.y_in_tile][vertex.x_in_tile];
    for (int i = last; i != kNone; i = before_[static_cast<size_t>(i)])
      if (vertices_[static_cast<size_t>(i)] == vertex) return static_cast<uint16_t>(i);
    before_.push_back(last);
    last = static_cast<int>(vertices_.size());
    vertices_.push_back(vertex);
    return static_cast<uint16_t>(last);
  }

 private:
  static constexpr int kNone = -1;
  std::vector<TornVertex>& vertices_;
  std::vector<int> before_;  // of each vertex: the one before at the same place
  int last_[kTileVertices][kTileVertices];
};

}  // namespace

void store_torn(std::vector<TornQuad> quads, MeshTile& tile) {
  static_assert(16 * kTilePx * kTilePx <= std::numeric_limits<uint16_t>::max());
  std::stable_sort(quads.begin(), quads.end(),
                   [](const TornQuad& a, const TornQuad& b) { return group_of(a) < group_of(b); });
  SharedVertices shared(tile.torn_vertices);
  for (int group = 0; group < 2 * kCells; ++group) {
    if (tile.torn.size() < quads.size() && group_of(quads[tile.torn.size()]) == group) shared.begin_group();
    while (tile.torn.size() < quads.size() && group_of(quads[tile.torn.size()]) == group) {
      const TornVertex(&c)[4] = quads[tile.torn.size()].corners;
      kernels::IndexedQuad quad;
      for (int k = 0; k < 4; ++k) quad.corner[k] = shared.index_of(c[k]);
      tile.torn.push_back(quad);
    }
    tile.torn_end[group] = static_cast<uint16_t>(tile.torn.size());
    tile.torn_vertices_end[group] = static_cast<uint16_t>(tile.torn_vertices.size());
  }
  tile.torn.shrink_to_fit();
  tile.torn_vertices.shrink_to_fit();
}

}  // namespace ldp::view
