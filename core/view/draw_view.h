// One view of meshes that are ready, whoever prepared them.
#pragma once

#include <vector>

#include "core/base/scratch_pool.h"
#include "core/view/mesh/mesh.h"
#include "core/view/raster/raster.h"
#include "core/view/raster/view_frustum.h"
#include "core/view/render.h"

namespace ldp::view {

// Throws when no view can be drawn for the camera.
void check_camera(const Camera& camera);

// Draws those of `tiles`, of the grid, that the frustum, which is the camera's, sees.
View draw_view(const std::vector<const MeshTile*>& tiles, const PanoramaGrid& grid, const ViewFrustum& frustum,
               const Camera& camera, const RenderOptions& options, ScratchPool<StripTarget>& strips, const Job& job);

}  // namespace ldp::view
