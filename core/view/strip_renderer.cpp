#include "core/view/strip_renderer.h"

#include "core/view/draw_view.h"
#include "core/view/mesh/mesh_strips.h"
#include "core/view/view_tuning.h"

namespace ldp {

struct StripRenderer::Prepared {
  view::MeshStrips strips;
  ScratchPool<view::StripTarget> targets;
};

StripRenderer::StripRenderer(const LayeredPanorama& panorama)
    : prepared_(new Prepared{{panorama, view::kStripTiles, view::BeyondFrames::nothing}, {}}) {}

StripRenderer::~StripRenderer() = default;

void StripRenderer::prepare(const Camera& camera, const Job& job) {
  view::check_camera(camera);
  const view::ViewFrustum frustum = prepared_->strips.frustum(camera);
  const view::Window window = frustum.window(0, camera.intrinsics.width);
  prepared_->strips.forget_unseen(frustum, window);
  prepared_->strips.make_seen(frustum, window, job);
}

View StripRenderer::render(const Camera& camera, const RenderOptions& options, const Job& job) {
  prepare(camera, job);
  return view::draw_view(prepared_->strips, camera, options, prepared_->targets, job);
}

}  // namespace ldp
