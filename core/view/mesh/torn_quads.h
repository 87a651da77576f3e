// The torn quads of a tile, found one by one, stored so that neighbours share vertices: each is then projected once.
#pragma once

#include <vector>

#include "core/view/mesh/mesh.h"

namespace ldp::view {

struct TornQuad {
  TornVertex corners[4];  // (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)
};

// Into tile.torn and what belongs to it.
void store_torn(std::vector<TornQuad> quads, MeshTile& tile);

}  // namespace ldp::view
