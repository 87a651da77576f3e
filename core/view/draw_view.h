// One view of strips of a mesh, whoever keeps them.
#pragma once

#include "core/base/scratch_pool.h"
#include "core/view/mesh/mesh_strips.h"
#include "core/view/raster/raster.h"
#include "core/view/render.h"

namespace ldp::view {

// Throws when no view can be drawn for the camera.
void check_camera(const Camera& camera);

// Makes the strips that the camera may see, where they are not made already, and draws them.
View draw_view(MeshStrips& mesh, const Camera& camera, const RenderOptions& options, ScratchPool<StripTarget>& strips,
               const Job& job);

}  // namespace ldp::view
