#include "core/view/render.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/view/draw_view.h"
#include "core/view/inpainting.h"
#include "core/view/mesh/mesh_strips.h"
#include "core/view/outlines.h"
#include "core/view/tears.h"
#include "core/view/view_tuning.h"

namespace ldp {

uint64_t rendering_bytes(const LdpDescription& description) {
  const PanoramaGrid& grid = description.panorama.grid;
  const uint64_t pixels = static_cast<uint64_t>(grid.width) * static_cast<uint64_t>(grid.height);
  uint64_t bytes = kMeshBytesAlways;
  for (const LdpLayerSummary& layer : description.layers)
    bytes += kMeshBytesPerPixel * pixels + kMeshBytesPerPresentPixel * layer.present_pixels;
  return bytes;
}

void view::check_camera(const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  const auto size = std::to_string(k.width) + "x" + std::to_string(k.height);
  if (k.width < 1 || k.height < 1 || k.width > kMaxViewSide || k.height > kMaxViewSide)
    throw std::runtime_error("render: view \"" + camera.name + "\" is " + size + " pixels; sides must be 1 to " +
                             std::to_string(kMaxViewSide));
  if (!(k.fx > 0) || !(k.fy > 0))
    throw std::runtime_error("render: view \"" + camera.name + "\" needs positive focal lengths fl_x, fl_y");
}

namespace {

Plane<float> depth_of(Plane<float> inverse_z) {
  for (float& z : inverse_z.samples) {
    if (z == view::kNothing)
      z = 0;
    else
      z = z > 0 ? 1 / z : std::numeric_limits<float>::infinity();
  }
  return inverse_z;
}

void store(const view::StripTarget& strip, View& rendered, Plane<float>& inverse_z) {
  for (int y = 0; y < strip.height; ++y) {
    const size_t from = strip.pixel(strip.x0, y), to = rendered.colour.index(strip.x0, y);
    for (size_t x = 0; x < static_cast<size_t>(strip.width); ++x) {
      const view::Fragment& opaque = strip.opaque[from + x];
      const view::Fragment shown = strip.first_soft[from + x] < 0 ? opaque : view::blend(strip, from + x);
      rendered.colour.samples[to + x] = {static_cast<uint8_t>(shown.colour), static_cast<uint8_t>(shown.colour >> 8),
                                         static_cast<uint8_t>(shown.colour >> 16)};
      rendered.alpha.samples[to + x] = static_cast<uint8_t>(view::alpha_of(shown.colour));
      inverse_z.samples[to + x] = shown.inverse_z;
    }
  }
}

}  // namespace

struct Renderer::Prepared {
  explicit Prepared(const LayeredPanorama& panorama)
      : strips(panorama, view::kRendererStripTiles, view::BeyondFrames::surfaces) {}
  explicit Prepared(LayeredPanorama&& panorama)
      : own(std::move(panorama)), strips(own, view::kRendererStripTiles, view::BeyondFrames::surfaces) {}

  void drop_needless() {
    const std::lock_guard lock(dropping);
    if (strips.all_made()) std::vector<Layer>().swap(own.layers);
  }

  LayeredPanorama own;  // empty if it is another's
  std::mutex dropping;  // guards its layers, once nobody reads them any more
  view::MeshStrips strips;
  ScratchPool<view::StripTarget> targets;
};

Renderer::Renderer(const LayeredPanorama& panorama) : prepared_(new Prepared(panorama)) {}

Renderer::Renderer(LayeredPanorama&& panorama) : prepared_(new Prepared(std::move(panorama))) {}

Renderer::~Renderer() = default;

void Renderer::prepare(const Job& job) {
  prepared_->strips.make_all(job);
  prepared_->drop_needless();
}

View Renderer::render(const Camera& camera, const RenderOptions& options, const Job& job) const {
  view::check_camera(camera);
  View view = view::draw_view(prepared_->strips, camera, options, prepared_->targets, job);
  prepared_->drop_needless();
  return view;
}

View view::draw_view(MeshStrips& mesh, const Camera& camera, const RenderOptions& options,
                     ScratchPool<StripTarget>& strip_pool, const Job& job) {
  const Intrinsics& k = camera.intrinsics;
  View rendered{RgbImage(k.width, k.height), Plane<uint8_t>(k.width, k.height), {}, 0};
  Plane<float> inverse_z(k.width, k.height);
  const ViewFrustum frustum = mesh.frustum(camera);
  const Window window = frustum.window(0, k.width);
  std::vector<const MeshTile*> seen = mesh.tiles(mesh.make_seen(frustum, window, job), options.layers);
  std::erase_if(seen, [&](const MeshTile* tile) { return !frustum.sees(*tile, window); });
  const int strips = (k.width + view::kStripPx - 1) / view::kStripPx;
  parallel_for(job, strips, [&](int i) {
    auto strip = strip_pool.take();
    strip->clear(i * view::kStripPx, std::min(view::kStripPx, k.width - i * view::kStripPx), k.height);
    draw(seen, frustum, *strip);
    store(*strip, rendered, inverse_z);
    strip_pool.give_back(std::move(strip));
  });
  const auto step = static_cast<float>(surface_slack(mesh.grid(), kOutlineParallaxPx));
  if (options.outlines) close_cracks(step, inverse_z, rendered.colour, rendered.alpha);
  Plane<float> behind;
  if (options.fill == Fill::background) {
    if (options.outlines) behind = background_behind_holes(inverse_z, rendered.alpha);
    rendered.invented_share = fill_background(inverse_z, rendered.colour, rendered.alpha);
  }
  if (options.outlines)
    soften_outlines(step, behind.empty() ? inverse_z : behind, rendered.alpha, job, rendered.colour);
  if (options.depth) rendered.depth = depth_of(std::move(inverse_z));
  return rendered;
}

}  // namespace ldp
